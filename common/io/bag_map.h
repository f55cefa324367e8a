// The map in a bag.
#pragma once

#include <string>

#include "common/io/log_choice.h"
#include "common/map/grid_map.h"
#include "common/ros/messages.h"

namespace parloc {

/// The last nav_msgs/OccupancyGrid of the bag's only such topic, or of choice.map_topic. Throws Error{input}
/// if there is none, if several topics have maps and none is chosen, and for a grid that is no map.
GridMap read_bag_map(const std::string& path, const LogChoice& choice);

/// Cells as map_saver would have written them and map_server read them again: at least 65 occupied, at most
/// 25 free, else unknown. Throws BrokenMessage for a grid that is empty, larger than a map may be, tilted, or
/// has other cells than its size says.
GridMap map_from_message(const OccupancyGridMessage& message, const std::string& name);

}  // namespace parloc
