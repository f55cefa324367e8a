// Which topics of a bag are a robot's log.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/bag/bag.h"
#include "common/io/log_choice.h"

namespace parloc {

/// What a topic of a bag is to a log.
enum class TopicRole { none, scan, multi_echo_scan, cloud, odometry, transforms, fixed_transforms };

/// The role of each topic. Throws Error{input} naming the bag, with the choice there is: for no scans, for
/// several with messages where one must be chosen, for a topic that is not there (the nearest is named) or
/// has another type.
std::vector<TopicRole> choose_topics(const BagReader& bag, const LogChoice& choice,
                                     const std::string& bag_name);

/// "scan" for "/scan", "front/scan" for "/front/scan": a LiDAR by its topic.
std::string sensor_name(const std::string& topic);

}  // namespace parloc
