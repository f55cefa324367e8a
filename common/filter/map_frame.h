// Estimates and particles of the grid frame as a user sees them, in the map frame; and what is wrong with a
// start.
#pragma once

#include <vector>

#include "common/filter/filter_backend.h"
#include "common/filter/pose_filter.h"
#include "common/filter/stages.h"
#include "common/map/grid_map.h"
#include "common/math/portable64.h"

namespace parloc {

/// Of the same errors, turned by `angle_rad`.
inline Covariance turned(const Covariance& c, double angle_rad) {
  const SinCos64 r = portable_sincos64(angle_rad);
  const double in_xx = c.v[0], in_xy = c.v[1], in_xt = c.v[2], in_yy = c.v[4], in_yt = c.v[5];
  const double xx = r.cos * r.cos * in_xx - 2 * r.cos * r.sin * in_xy + r.sin * r.sin * in_yy;
  const double yy = r.sin * r.sin * in_xx + 2 * r.cos * r.sin * in_xy + r.cos * r.cos * in_yy;
  const double xy = r.cos * r.sin * (in_xx - in_yy) + (r.cos * r.cos - r.sin * r.sin) * in_xy;
  const double xt = r.cos * in_xt - r.sin * in_yt;
  const double yt = r.sin * in_xt + r.cos * in_yt;
  return {{xx, xy, xt, xy, yy, yt, xt, yt, c.v[8]}};
}

inline PoseEstimate in_map_frame(const Moments& m, const Pose& T_map_grid) {
  PoseEstimate e;
  e.mean = compose(T_map_grid, {m.x, m.y, m.theta});
  e.weight = m.weight;
  e.heading_resultant = m.resultant;
  e.covariance = turned({{m.xx, m.xy, m.xt, m.xy, m.yy, m.yt, m.xt, m.yt, m.tt}}, T_map_grid.theta_rad);
  return e;
}

/// At most `most` of them, evenly by slot; weights are shares of all.
std::vector<Particle> in_map_frame(const ParticleSet& set, const Pose& T_map_grid, std::size_t most);

/// Moves particles of one grid frame into another; those of the same stay as they are, bit by bit.
void in_other_grid(ParticleSet& set, const Pose& T_map_from, const Pose& T_map_to);

/// Throws Error{input} unless it is a map (validate) with a free cell.
void check_map(const GridMap& map);
/// Throws Error{input} unless the pose is finite and inside the map, and the standard deviations are finite
/// and not negative, or the covariance is one (root_of).
void check_start(const GridMap& map, const Pose& pose_in_map, const Covariance& covariance);
void check_start(const GridMap& map, const Pose& pose_in_map, double sigma_x_m, double sigma_y_m,
                 double sigma_theta_rad);

}  // namespace parloc
