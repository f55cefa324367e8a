#include "common/filter/map_frame.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/error.h"
#include "common/filter/pose/gaussian.h"

namespace parloc {

std::vector<Particle> in_map_frame(const ParticleSet& set, const Pose& T, std::size_t most) {
  const SinCos64 r = portable_sincos64(T.theta_rad);  // once: there may be a million
  const std::size_t count = set.x.size(), kept = std::min(count, most);
  double total = 0.0;
  for (const float log_weight : set.log_weight) total += portable_exp(log_weight);
  std::vector<Particle> out(kept);
  for (std::size_t k = 0; k < kept; ++k) {
    const std::size_t i = k * count / kept;
    out[k].x_m = static_cast<float>(T.x_m + r.cos * set.x[i] - r.sin * set.y[i]);
    out[k].y_m = static_cast<float>(T.y_m + r.sin * set.x[i] + r.cos * set.y[i]);
    out[k].theta_rad = static_cast<float>(wrap64(T.theta_rad + set.theta[i]));
    out[k].weight = static_cast<float>(portable_exp(set.log_weight[i]) / total);
  }
  return out;
}

void in_other_grid(ParticleSet& set, const Pose& T_map_from, const Pose& T_map_to) {
  const Pose T = relative(T_map_from, T_map_to);  // the old grid, seen from the new one
  const Pose &a = T_map_from, &b = T_map_to;
  if (a.x_m == b.x_m && a.y_m == b.y_m && a.theta_rad == b.theta_rad) return;
  const SinCos64 r = portable_sincos64(T.theta_rad);
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    const double x = set.x[i], y = set.y[i];
    set.x[i] = static_cast<float>(T.x_m + r.cos * x - r.sin * y);
    set.y[i] = static_cast<float>(T.y_m + r.sin * x + r.cos * y);
    set.theta[i] = wrap(static_cast<float>(wrap64(T.theta_rad + set.theta[i])));
  }
}

void check_map(const GridMap& map) {
  validate(map);
  if (std::none_of(map.cells.begin(), map.cells.end(), [](Cell c) { return c == Cell::free; }))
    throw Error(ErrorKind::input, map.name + ": the map has no free cell");
}

namespace {

void check_start_pose(const GridMap& map, const Pose& pose) {
  if (!is_finite(pose)) throw Error(ErrorKind::input, "start pose: expected finite numbers");
  const Pose in_grid = relative(pose, map.T_map_grid);
  const double cells_x = in_grid.x_m / map.resolution_m, cells_y = in_grid.y_m / map.resolution_m;
  if (!(cells_x >= 0 && cells_y >= 0 && cells_x < map.width && cells_y < map.height))
    throw Error(ErrorKind::input, "start pose (" + std::to_string(pose.x_m) + ", " +
                                      std::to_string(pose.y_m) + "): expected a point inside the map " +
                                      map.name);
}

}  // namespace

void check_start(const GridMap& map, const Pose& pose, const Covariance& covariance) {
  check_start_pose(map, pose);
  (void)root_of(covariance);
}

void check_start(const GridMap& map, const Pose& pose, double sigma_x_m, double sigma_y_m,
                 double sigma_theta_rad) {
  check_start_pose(map, pose);
  for (const double sigma : {sigma_x_m, sigma_y_m, sigma_theta_rad})
    if (!(sigma >= 0) || !std::isfinite(sigma))
      throw Error(ErrorKind::input,
                  "start pose: expected standard deviations that are finite and not negative");
}

}  // namespace parloc
