// The map in a bag.
#pragma once

#include <string>

#include "common/io/log_choice.h"
#include "common/map/grid_map.h"

namespace parloc {

/// The last nav_msgs/OccupancyGrid of the bag's only such topic, or of choice.map_topic. Throws Error{input}
/// if there is none, if several topics have maps and none is chosen, and for a grid that is no map.
GridMap read_bag_map(const std::string& path, const LogChoice& choice);

}  // namespace parloc
