#include "common/simulator/simulated_walls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kSlack_m = 1e-9;

double hit(const GridWall& s, const Pose& ray, const SinCos64& d) {
  // The wall as the ray sees it: x along the ray, y across.
  const auto along = [&](double x, double y) { return (x - ray.x_m) * d.cos + (y - ray.y_m) * d.sin; };
  const auto across = [&](double x, double y) { return (y - ray.y_m) * d.cos - (x - ray.x_m) * d.sin; };
  const double ax = along(s.ax, s.ay), ay = across(s.ax, s.ay);
  const double bx = along(s.bx, s.by), by = across(s.bx, s.by);
  if (std::min(ay, by) > kSlack_m || std::max(ay, by) < -kSlack_m) return kNone;
  if (std::fabs(by - ay) <= kSlack_m) {
    if (std::max(ax, bx) < 0.0) return kNone;
    return std::max(std::min(ax, bx), 0.0);
  }
  const double t = ax + (bx - ax) * std::clamp(-ay / (by - ay), 0.0, 1.0);
  return t >= 0.0 ? t : kNone;
}

}  // namespace

std::optional<double> cast_at_walls(const std::vector<GridWall>& walls, const Pose& T_grid_ray,
                                    double range_max_m) {
  const SinCos64 direction = portable_sincos64(T_grid_ray.theta_rad);
  double nearest = kNone;
  for (const GridWall& s : walls) nearest = std::min(nearest, hit(s, T_grid_ray, direction));
  if (!(nearest < range_max_m)) return std::nullopt;
  return nearest;
}

}  // namespace parloc
