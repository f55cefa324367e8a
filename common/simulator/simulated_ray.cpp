// Where a simulated ray ends.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "common/math/portable64.h"
#include "common/simulator/simulator.h"

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

/// Distance [m] to the nearest wall along the ray that starts at the pose (grid frame) in the direction of
/// its heading; nothing if it is beyond range_max_m. float64, all walls tried one by one. Ends belong to a
/// wall; a ray along a wall meets its nearer end, or is at 0 if it starts within.
std::optional<double> cast_at_walls(const std::vector<GridWall>& walls, const Pose& T_grid_ray,
                                    double range_max_m) {
  const SinCos64 direction = portable_sincos64(T_grid_ray.theta_rad);
  double nearest = kNone;
  for (const GridWall& s : walls) nearest = std::min(nearest, hit(s, T_grid_ray, direction));
  if (!(nearest < range_max_m)) return std::nullopt;
  return nearest;
}

}  // namespace

SimulatedHit cast_simulated_ray(const GridMap& map, double x_m, double y_m, double angle_rad,
                                double range_max_m) {
  const Pose start = relative({x_m, y_m, angle_rad}, map.T_map_grid);  // the ray in the grid frame
  const SinCos64 direction = portable_sincos64(start.theta_rad);
  const double cell_m = map.resolution_m;
  const SimulatedHit miss{range_max_m, 0, 0, false};
  const double u = std::floor(start.x_m / cell_m);
  const double v = std::floor(start.y_m / cell_m);
  if (!(u >= 0.0 && v >= 0.0 && u < map.width && v < map.height)) return miss;
  if (!map.walls.empty()) {
    const std::optional<double> range_m = cast_at_walls(map.walls, start, range_max_m);
    return range_m ? SimulatedHit{*range_m, 0, 0, true} : miss;
  }
  int i = static_cast<int>(u);
  int j = static_cast<int>(v);
  // Distance to the next grid line of each axis, from its integer index: no error accumulates.
  const bool no_x = std::fabs(direction.cos) < 1e-12;
  const bool no_y = std::fabs(direction.sin) < 1e-12;
  const auto next_x_m = [&] {
    return no_x ? kNone : ((i + (direction.cos > 0.0 ? 1 : 0)) * cell_m - start.x_m) / direction.cos;
  };
  const auto next_y_m = [&] {
    return no_y ? kNone : ((j + (direction.sin > 0.0 ? 1 : 0)) * cell_m - start.y_m) / direction.sin;
  };
  double tx_m = next_x_m();
  double ty_m = next_y_m();
  double t_m = 0.0;
  while (map.contains(i, j)) {
    if (map.at(i, j) == Cell::occupied) return {std::fmax(t_m, 0.0), i, j, true};
    const bool step_x = tx_m < ty_m;
    t_m = step_x ? tx_m : ty_m;
    if (t_m >= range_max_m) return miss;
    if (step_x) {
      i += direction.cos > 0.0 ? 1 : -1;
      tx_m = next_x_m();
    } else {
      j += direction.sin > 0.0 ? 1 : -1;
      ty_m = next_y_m();
    }
  }
  return miss;
}

}  // namespace parloc
