#include "common/simulator/drive.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable64.h"

namespace parloc {

Drive plan_drive(const WaypointPath& path) {
  Drive drive;
  double now_s = 0.0;
  Pose pose{path.points[0].x_m, path.points[0].y_m, 0.0};
  const auto add = [&](double duration_s, double turn_rad, double dx_m, double dy_m) {
    if (duration_s <= 0.0) return;
    drive.phases.push_back({now_s, now_s + duration_s, pose, turn_rad, dx_m, dy_m});
    now_s += duration_s;
  };
  const auto spin = [&](const Waypoint& point) {
    add(std::fabs(point.spin_rad) / path.turn_rate_rad_s, point.spin_rad, 0.0, 0.0);
    pose.theta_rad = wrap64(pose.theta_rad + point.spin_rad);
  };
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const Waypoint& here = path.points[i];
    const Waypoint& next = path.points[i + 1];
    const double dx = next.x_m - here.x_m;
    const double dy = next.y_m - here.y_m;
    const double heading = wrap64(portable_atan2_64(dy, dx));
    if (i == 0) pose.theta_rad = heading;
    add(here.pause_s, 0.0, 0.0, 0.0);
    spin(here);
    const double turn = wrap64(heading - pose.theta_rad);
    add(std::fabs(turn) / path.turn_rate_rad_s, turn, 0.0, 0.0);
    pose.theta_rad = heading;
    add(std::sqrt(dx * dx + dy * dy) / path.speed_mps, 0.0, dx, dy);
    pose = {next.x_m, next.y_m, heading};
  }
  add(path.points.back().pause_s, 0.0, 0.0, 0.0);
  spin(path.points.back());
  return drive;
}

Pose pose_at(const Drive& drive, double time_s) {
  const auto later = [](double t, const DrivePhase& phase) { return t < phase.end_s; };
  auto it = std::upper_bound(drive.phases.begin(), drive.phases.end(), time_s, later);
  if (it == drive.phases.end()) --it;
  const double part = std::clamp((time_s - it->start_s) / (it->end_s - it->start_s), 0.0, 1.0);
  return {it->from.x_m + part * it->dx_m, it->from.y_m + part * it->dy_m,
          wrap64(it->from.theta_rad + part * it->turn_rad)};
}

double path_length_m(const WaypointPath& path) {
  double length_m = 0.0;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const double dx = path.points[i + 1].x_m - path.points[i].x_m;
    const double dy = path.points[i + 1].y_m - path.points[i].y_m;
    length_m += std::sqrt(dx * dx + dy * dy);
  }
  return length_m;
}

}  // namespace parloc
