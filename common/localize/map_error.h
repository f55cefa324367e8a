// What a map of cells cannot say about a place, however many scans were taken there.
#pragma once

#include <array>
#include <vector>

#include "common/filter/pose_filter.h"
#include "common/math/pose.h"
#include "common/model/beams.h"

namespace parloc {

/// How a scan's walls hold a pose, x, y and heading of the base frame.
struct WallGeometry {
  /// Where the pose goes if all walls are one metre farther away than the map has them [m, m, rad].
  std::array<double, 3> all_farther{};
  /// If each is off by itself: the inverse of the mean information of a beam, by rows.
  std::array<double, 9> each_off{};
  bool known = false;
};

/// From the ranges that the map shows at a pose. Needs some walls; beams that end elsewhere do not count.
WallGeometry wall_geometry(const BeamTable& beams, const std::vector<float>& expected_m, double resolution_m);

/// Walls are drawn with whole cells, and the robot's LiDAR has an error of its own that all its beams share:
/// scans from one spot all err alike, and a filter that takes them for independent grows surer and surer.
/// This is what its covariance lacks, map frame.
Covariance map_error(const WallGeometry& walls, double heading_rad, double resolution_m);
/// Adds it.
void add_map_error(const WallGeometry& walls, double heading_rad, double resolution_m,
                   Covariance& covariance);

}  // namespace parloc
