// The stages as OpenMP loops; contract in common/filter/stages.h. The queue has at least one thread.
#pragma once

#include "common/filter/kld.h"
#include "common/filter/stages.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

struct FilterStages {
#include "common/filter/stage_list.inc"
};

}  // namespace parloc::cpu
