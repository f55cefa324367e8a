#include "common/eval/families/family_trial.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "common/simulator/changed_world.h"
#include "common/simulator/drive.h"

namespace parloc {
namespace {

constexpr double kRobot_m = 0.35;  // what a robot needs on both sides: nothing is put there

/// Straight along the corridor.
WaypointPath corridor_path(const DrawnDrive& d) {
  WaypointPath path;
  path.name = "along a corridor";
  path.speed_mps = d.speed_mps;
  path.turn_rate_rad_s = d.turn_rate_rad_s;
  const double from_m = d.corridor_start_m, y_m = 0.5 * d.corridor_width_m;
  path.points = {{from_m, y_m}, {from_m + d.speed_mps * d.duration_s, y_m}};
  return path;
}

/// The path as far as the robot gets by then: what lies beyond need not be simulated.
void cut_path(WaypointPath& path, double duration_s) {
  constexpr double kShortest_m = 0.1;  // a leg, be it only turned to
  for (std::size_t n = 2; n <= path.points.size(); ++n) {
    WaypointPath first = path;
    first.points.resize(n);
    const Drive drive = plan_drive(first);
    if (drive.duration_s() < duration_s && n < path.points.size()) continue;
    const Waypoint &a = first.points[n - 2], &b = first.points[n - 1];
    const Pose end = pose_at(drive, duration_s);
    const double leg_m = distance_m({a.x_m, a.y_m, 0.0}, {b.x_m, b.y_m, 0.0});
    const double part =
        std::clamp(distance_m({a.x_m, a.y_m, 0.0}, end), std::min(kShortest_m, leg_m), leg_m) / leg_m;
    first.points[n - 1] = {a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m)};
    path = std::move(first);
    return;
  }
}

WaypointPath draw_path(const DrawnDrive& d, const Place& place, double duration_s, std::uint64_t seed) {
  if (d.place == kCorridor) return corridor_path(d);
  WaypointPath path = place.area->wander(duration_s, d.speed_mps, d.turn_rate_rad_s, seed);
  path.points.front().pause_s = d.stand_s;
  cut_path(path, duration_s);
  return path;
}

/// The world that the drive meets: the place's own, or a changed copy.
std::shared_ptr<const GridMap> world_of(const DrawnDrive& d, const Place& place, const WaypointPath& path) {
  if (d.furniture_share > 0.0 || d.doors_share > 0.0) {
    const WorldChange change = d.furniture_share > 0.0
                                   ? move_furniture(*place.map, path, kRobot_m, d.furniture_share, d.seed)
                                   : change_doors(*place.map, path, kRobot_m, d.doors_share, d.seed);
    return std::make_shared<const GridMap>(changed_world(*place.world, *place.map, change));
  }
  if (d.map_scale == 1.0) return place.world;
  GridMap scaled = *place.world;
  scaled.resolution_m /= d.map_scale;
  return std::make_shared<const GridMap>(std::move(scaled));
}

void scale_path(WaypointPath& path, const Pose& T_map_grid, double scale) {
  for (Waypoint& point : path.points) {
    const Pose p = scaled_about_grid({point.x_m, point.y_m, 0.0}, T_map_grid, scale);
    point.x_m = p.x_m;
    point.y_m = p.y_m;
  }
}

/// About the pose that the robot is at, or anywhere on the map of another place.
PoseGuess draw_start(const DrawnDrive& d, const Places& places, const Pose& truth) {
  Pose where = truth;
  if (d.localized_on != d.place) {
    const WaypointPath path = places.at(d.localized_on).area->wander(1.0, 1.0, 1.0, d.seed);
    where = pose_at(plan_drive(path), 0.0);
  }
  return {compose(where, d.start_error), d.start_sigma_m, d.start_sigma_rad, 1.0};
}

TrialPlan plan_of(const DrawnDrive& d) {
  TrialPlan plan;
  plan.task = d.family == Family::kidnapped       ? TrialTask::kidnap
              : d.family == Family::unknown_start ? TrialTask::global
                                                  : TrialTask::track;
  plan.duration_s = plan.task == TrialTask::kidnap ? 0.5 * d.duration_s : d.duration_s;
  plan.speed_mps = d.speed_mps;
  plan.turn_rate_rad_s = d.turn_rate_rad_s;
  return plan;
}

}  // namespace

FamilyTrial make_trial(const DrawnDrive& d, const Places& places) {
  FamilyTrial trial;
  trial.plan = plan_of(d);
  const Place place =
      d.place == kCorridor ? corridor_place(kCorridorLength_m, d.corridor_width_m) : places.at(d.place);
  const bool kidnapped = trial.plan.task == TrialTask::kidnap;
  std::vector<Scenario> drives(kidnapped ? 2 : 1, d.robot);
  for (std::size_t k = 0; k < drives.size(); ++k) {
    drives[k].seed += k;
    drives[k].path = draw_path(d, place, trial.plan.duration_s, drives[k].seed);
  }
  const std::shared_ptr<const GridMap> world = world_of(d, place, drives[0].path);
  scale_path(drives[0].path, place.map->T_map_grid, 1.0 / d.map_scale);
  if (d.clutter_share > 0.0)
    drives[0].clutter =
        clutter_for_share(drives[0], *world, trial.plan.duration_s, d.clutter_share, d.people_part);
  trial.log = simulate_drives(std::move(drives), *world, trial.plan.duration_s);
  for (StampedPose& truth : trial.log.truth)
    if (d.map_scale != 1.0) truth.pose = scaled_about_grid(truth.pose, place.map->T_map_grid, d.map_scale);
  trial.log.elsewhere = d.localized_on != d.place;
  trial.log.start = draw_start(d, places, trial.log.truth.front().pose);
  trial.map = trial.log.elsewhere ? places.at(d.localized_on).map : place.map;
  if (!kidnapped) trial.events = corrupt_odometry(trial.log.records, d.corruption, d.seed);
  return trial;
}

}  // namespace parloc
