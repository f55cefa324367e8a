// How far a log has been mapped: what a checkpoint of `parloc slam` holds besides the filter's state.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/slam/growth.h"

namespace parloc::tools::slam {

struct MapPosition {
  std::string log_name;          ///< For messages.
  std::size_t scans = 0;         ///< Done.
  std::string digest;            ///< Of the log as far as it was read then (DigestedLog).
  std::vector<double> step_s;    ///< RayWall time of each scan that was taken in.
  double wall_s = 0.0;           ///< Of all that was done so far.
  bool odometry_chosen = false;  ///< The settings' odometry is from the scans because the log has none.
  std::vector<Growth> growth;    ///< What the report shows of the growing map.
};

std::string to_bytes(const MapPosition& position);
/// `name` stands for the checkpoint in messages. Throws Error{input}.
MapPosition map_position_from(const std::string& bytes, const std::string& name);

}  // namespace parloc::tools::slam
