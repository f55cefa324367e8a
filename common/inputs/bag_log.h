// The log in a bag: scans with where their LiDAR sits and the odometry at their time.
#pragma once

#include <memory>
#include <string>

#include "common/inputs/topic_choice.h"
#include "common/io/log.h"

namespace parloc {

/// Reads a bag as it would be driven (docs/bags.md). Throws Error{input} if it cannot be opened or the choice
/// of topics fails; next() throws it for scans of which nobody says where their LiDAR sits, or that do not
/// lie in the floor's plane. A message that is broken is skipped and counted.
std::unique_ptr<LogReader> open_bag_log(const std::string& path, const LogChoice& choice);

}  // namespace parloc
