// The ranges that a scan should have at one pose: rays of the host, beside those of the backends.
#pragma once

#include <cstdint>
#include <vector>

#include "common/filter/stages.h"
#include "common/map/grid_map.h"
#include "common/map/rays/wall_index.h"
#include "common/model/beams.h"

namespace parloc {

/// Built once per map; does not keep it. The same ranges as every backend's, to the bit.
class PoseRays {
 public:
  explicit PoseRays(const GridMap& map, bool unknown_blocks = true);

  /// Expected range [m] of every beam, at a pose of the grid frame. Keeps the capacity of `expected_m`.
  void cast(const BeamTable& beams, const Pose& pose_in_grid, std::vector<float>& expected_m) const;
  /// Expected range [m] of one ray from a point of the grid frame, at most range_max_m.
  float cast(float x_m, float y_m, float heading_rad, float range_max_m) const;

 private:
  WallIndex walls_;
  ZeroedVector<std::uint8_t> skip_;
  RayMap map_;
};

}  // namespace parloc
