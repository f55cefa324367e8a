// The true poses in a bag.
#pragma once

#include <string>

#include "common/io/log_choice.h"
#include "common/model/trajectory.h"

namespace parloc {

/// With choice.truth_frame, where /tf says that the base (choice.base_frame, else "base_footprint" or
/// "base_link", whichever there is) is in that frame, once for every transform of the base. Else the poses of
/// choice.truth_topic, or of the bag's only topic of poses (geometry_msgs/PoseStamped,
/// PoseWithCovarianceStamped, TransformStamped; nav_msgs/Odometry only by name): of the base, as they stand.
/// Seen from above, in the order of the bag. Poses that are not finite are left out. Throws Error{input} if
/// there are none.
Trajectory read_bag_truth(const std::string& path, const LogChoice& choice);

}  // namespace parloc
