// Where a simulated ray meets walls that are segments.
#pragma once

#include <optional>
#include <vector>

#include "common/map/grid_wall.h"
#include "common/math/pose.h"

namespace parloc {

/// Distance [m] to the nearest wall along the ray that starts at the pose (grid frame) in the direction of
/// its heading; nothing if it is beyond range_max_m. float64, all walls tried one by one, written apart from
/// the filter's casters on purpose. Ends belong to a wall; a ray along a wall meets its nearer end, or is at
/// 0 if it starts within.
std::optional<double> cast_at_walls(const std::vector<GridWall>& walls, const Pose& T_grid_ray,
                                    double range_max_m);

}  // namespace parloc
