#include "common/simulator/clutter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/philox.h"
#include "common/math/portable64.h"
#include "common/simulator/drive.h"

namespace parloc {
namespace {

constexpr double kNone_m = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kPersonSlots = 1u << 20;  // slots of boxes lie below

/// Four uniform numbers of one thing; `draw` counts its tries.
struct Draws {
  double u[4];
  Draws(std::uint32_t slot, std::uint32_t draw, std::uint64_t seed) {
    const Philox4x32 r = philox(slot, draw, Stream::simulated_clutter, 0, seed);
    for (int k = 0; k < 4; ++k) u[k] = static_cast<double>(uniform_unit(r.w[k]));
  }
  double between(int k, double low, double high) const { return low + u[k] * (high - low); }
};

double distance_to_leg_m(const Waypoint& a, const Waypoint& b, double x_m, double y_m) {
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  const double along = ((x_m - a.x_m) * dx + (y_m - a.y_m) * dy) / (dx * dx + dy * dy);
  const double t = std::clamp(along, 0.0, 1.0);
  const double off_x = x_m - a.x_m - t * dx, off_y = y_m - a.y_m - t * dy;
  return std::sqrt(off_x * off_x + off_y * off_y);
}

double distance_to_path_m(const WaypointPath& path, double x_m, double y_m) {
  double least_m = kNone_m;
  for (std::size_t k = 1; k < path.points.size(); ++k)
    least_m = std::min(least_m, distance_to_leg_m(path.points[k - 1], path.points[k], x_m, y_m));
  return least_m;
}

/// A point beside the path: on a leg chosen by length, up to `reach_m` off it.
Waypoint beside_path(const WaypointPath& path, const Draws& d, double reach_m) {
  const auto leg_m = [&](std::size_t k) {
    const double dx = path.points[k].x_m - path.points[k - 1].x_m;
    const double dy = path.points[k].y_m - path.points[k - 1].y_m;
    return std::sqrt(dx * dx + dy * dy);
  };
  double left_m = d.u[0] * path_length_m(path);
  std::size_t k = 1;
  while (k + 1 < path.points.size() && left_m > leg_m(k)) left_m -= leg_m(k++);
  const Waypoint &a = path.points[k - 1], &b = path.points[k];
  const double t = std::min(left_m / leg_m(k), 1.0), off_m = d.between(1, -reach_m, reach_m);
  const double ux = (b.x_m - a.x_m) / leg_m(k), uy = (b.y_m - a.y_m) / leg_m(k);
  return {a.x_m + t * (b.x_m - a.x_m) - off_m * uy, a.y_m + t * (b.y_m - a.y_m) + off_m * ux, 0.0};
}

/// Along a ray from (x, y) in direction (c, s), in the frame of the thing.
double range_to_circle_m(double x_m, double y_m, double c, double s, double radius_m) {
  const double along = -(x_m * c + y_m * s);
  const double square = x_m * x_m + y_m * y_m - along * along;
  const double half_square = radius_m * radius_m - square;
  if (half_square <= 0.0) return kNone_m;
  const double near_m = along - std::sqrt(half_square);
  return near_m > 0.0 ? near_m : kNone_m;  // from inside one: it is not seen
}

double range_to_box_m(double x_m, double y_m, double c, double s, double half_length_m, double half_width_m) {
  double from = 0.0, to = kNone_m;
  const double start[] = {x_m, y_m}, direction[] = {c, s}, half[] = {half_length_m, half_width_m};
  for (int axis = 0; axis < 2; ++axis) {
    if (std::fabs(direction[axis]) < 1e-12) {
      if (std::fabs(start[axis]) > half[axis]) return kNone_m;
      continue;
    }
    const double a = (-half[axis] - start[axis]) / direction[axis];
    const double b = (half[axis] - start[axis]) / direction[axis];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from > 0.0 && from <= to ? from : kNone_m;
}

}  // namespace

ClutterField::ClutterField(const Scenario& scenario, const GridMap& map)
    : person_radius_m_(scenario.clutter.person_radius_m) {
  const SimulatedClutter& clutter = scenario.clutter;
  constexpr std::uint32_t kTries = 64;
  for (std::uint32_t slot = 0; slot < static_cast<std::uint32_t>(clutter.boxes); ++slot) {
    const Draws shape(slot, kTries, scenario.seed);
    const double length_m = shape.between(0, clutter.box_min_m, clutter.box_max_m);
    const double width_m = shape.between(1, clutter.box_min_m, clutter.box_max_m);
    const double heading_rad = shape.between(2, -kPi, kPi);
    const double clear_m = clutter.clearance_m + 0.5 * std::sqrt(length_m * length_m + width_m * width_m);
    for (std::uint32_t attempt = 0; attempt < kTries; ++attempt) {
      const Waypoint at =
          beside_path(scenario.path, Draws(slot, attempt, scenario.seed), clutter.box_reach_m);
      if (map.at_point(at.x_m, at.y_m) != Cell::free) continue;
      if (distance_to_path_m(scenario.path, at.x_m, at.y_m) < clear_m) continue;
      boxes_.push_back({{at.x_m, at.y_m, heading_rad}, 0.5 * length_m, 0.5 * width_m});
      break;
    }
  }
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(clutter.people); ++k) {
    const Draws a(kPersonSlots + k, 0, scenario.seed), b(kPersonSlots + k, 1, scenario.seed);
    const double sway_m = a.between(3, 0.0, 0.3);
    const double least_m = clutter.person_min_m + sway_m;
    people_.push_back({a.between(0, -kPi, kPi), a.between(1, -0.15, 0.15),
                       a.between(2, least_m, std::max(least_m, clutter.person_max_m - sway_m)), sway_m,
                       b.between(0, 0.2, 1.0), b.between(1, -kPi, kPi)});
  }
}

double ClutterField::range(const Pose& robot, double time_s, double x_m, double y_m, double angle_rad,
                           double range_max_m) const {
  double nearest_m = range_max_m;
  for (const Box& box : boxes_) {
    const double dx = x_m - box.pose.x_m, dy = y_m - box.pose.y_m;
    const double reach_m = nearest_m + box.half_length_m + box.half_width_m;
    if (dx * dx + dy * dy > reach_m * reach_m) continue;
    const Pose ray = relative({x_m, y_m, angle_rad}, box.pose);
    const SinCos64 d = portable_sincos64(ray.theta_rad);
    nearest_m = std::min(nearest_m,
                         range_to_box_m(ray.x_m, ray.y_m, d.cos, d.sin, box.half_length_m, box.half_width_m));
  }
  if (people_.empty()) return nearest_m;
  const SinCos64 d = portable_sincos64(wrap64(angle_rad));
  for (const Person& p : people_) {
    const SinCos64 at = portable_sincos64(wrap64(p.bearing_rad + p.turn_rad_s * time_s));
    const double sway = portable_sincos64(wrap64(p.sway_rad_s * time_s + p.phase_rad)).sin;
    const double distance_m = p.distance_m + p.sway_m * sway;
    const double px = robot.x_m + distance_m * at.cos, py = robot.y_m + distance_m * at.sin;
    nearest_m = std::min(nearest_m, range_to_circle_m(x_m - px, y_m - py, d.cos, d.sin, person_radius_m_));
  }
  return nearest_m;
}

}  // namespace parloc
