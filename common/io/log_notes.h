// The notes of a log that its user's settings leave open.
#pragma once

#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/model/scan_config.h"

namespace parloc {

/// Their texts, in the order in which the reader made them; without those that an entry of `lidars` has
/// settled: angles by angle_min and angle_step, a moving mount by x, y and yaw.
std::vector<std::string> open_notes(const std::vector<LogNote>& notes,
                                    const std::vector<LidarConfig>& lidars);

}  // namespace parloc
