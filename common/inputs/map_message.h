// Maps as ROS sends them, nav_msgs/OccupancyGrid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/map/grid_map.h"
#include "common/ros/messages.h"

namespace parloc {

/// Cells as map_saver would have written them and map_server read them again: at least 65 occupied, at most
/// 25 free, else unknown. Throws BrokenMessage for a grid that is empty, larger than a map may be, tilted, or
/// has other cells than its size says.
GridMap map_from_message(const OccupancyGridMessage& message, const std::string& name);

/// The other way: cells are 0, 100 or -1. Of a map of more than `most_cells`, squares of cells become one:
/// occupied if one of them is, else free if one is.
OccupancyGridMessage message_of_map(const GridMap& map, const MessageHeader& header,
                                    std::size_t most_cells = SIZE_MAX);

}  // namespace parloc
