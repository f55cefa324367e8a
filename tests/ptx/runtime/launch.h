// Runs the blocks of a launch.
#pragma once

#include "tests/ptx/device/thread.h"

namespace ptx {

/// One block after the other, in an order that the seed and the launch's number give. A block that seems
/// to wait for another is set aside, and others run.
void run_launch(const Launch& launch);

}  // namespace ptx
