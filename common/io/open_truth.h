// Opens a true trajectory, whatever holds it.
#pragma once

#include <string>

#include "common/io/log_choice.h"
#include "common/model/trajectory.h"

namespace parloc {

/// A file as read_tum() has them, or a bag, told by content. Throws Error{input} as their readers.
Trajectory open_truth(const std::string& path, const LogChoice& choice);

}  // namespace parloc
