#include "common/simulator/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "common/error.h"
#include "common/math/philox.h"
#include "common/math/portable64.h"
#include "common/model/motion.h"
#include "common/simulator/clutter.h"
#include "common/simulator/drive.h"
#include "common/simulator/wheel_odometry.h"

namespace parloc {
namespace {

constexpr std::int64_t kTicksPerSecond = 200;  // 5 ms
constexpr double kMostRanges = 5e7;            // 200 MB, and twice that as text
constexpr double kMostReadings = 5e6;

/// The drive in ticks of 5 ms: a stamp is tick / 200, the double nearest to it.
struct Schedule {
  std::int64_t odometry_ticks = 0;
  std::int64_t scan_ticks = 0;
  std::int64_t last_tick = 0;
  std::vector<std::int64_t> delay_ticks;  // by LiDAR
};

std::vector<const SimulatedLidar*> all_lidars(const Scenario& scenario) {
  std::vector<const SimulatedLidar*> lidars{&scenario.lidar};
  for (const SimulatedLidar& lidar : scenario.more_lidars) lidars.push_back(&lidar);
  return lidars;
}

std::int64_t period_ticks(double rate_hz, const char* key) {
  const double ticks = static_cast<double>(kTicksPerSecond) / rate_hz;
  const double whole = std::rint(ticks);
  if (!(whole >= 1.0 && std::fabs(ticks - whole) < 1e-6)) {
    throw Error(ErrorKind::config,
                fmt::format("{} must have a period that is a multiple of 5 ms, got {} Hz", key, rate_hz));
  }
  return static_cast<std::int64_t>(whole);
}

/// Scans come with odometry: so they come when that does.
std::int64_t delay_ticks(const SimulatedLidar& lidar, std::int64_t odometry_ticks) {
  const double steps =
      lidar.delay_s * static_cast<double>(kTicksPerSecond) / static_cast<double>(odometry_ticks);
  const double whole = std::rint(steps);
  if (std::fabs(steps - whole) > 1e-6) {
    throw Error(
        ErrorKind::config,
        fmt::format("lidar.delay must be a multiple of the odometry's period, got {} s", lidar.delay_s));
  }
  return static_cast<std::int64_t>(whole) * odometry_ticks;
}

Schedule make_schedule(const Scenario& scenario, double duration_s) {
  Schedule s;
  s.odometry_ticks = period_ticks(scenario.odometry.rate_hz, "odometry.rate");
  s.scan_ticks = period_ticks(scenario.scan_rate_hz, "scan_rate");
  if (s.scan_ticks % s.odometry_ticks != 0) {
    throw Error(ErrorKind::config,
                fmt::format("odometry.rate must be a multiple of scan_rate, got {} and {} Hz",
                            scenario.odometry.rate_hz, scenario.scan_rate_hz));
  }
  double beams = 0.0;
  for (const SimulatedLidar* lidar : all_lidars(scenario)) {
    beams += lidar->beams;
    s.delay_ticks.push_back(delay_ticks(*lidar, s.odometry_ticks));
    if (lidar->scan_time_s > 1.0 / scenario.scan_rate_hz) {
      throw Error(ErrorKind::config,
                  fmt::format("lidar.scan_time must be at most the {} s between scans, got {}",
                              1.0 / scenario.scan_rate_hz, lidar->scan_time_s));
    }
  }
  const double ranges = duration_s * scenario.scan_rate_hz * beams;
  const double readings = duration_s * scenario.odometry.rate_hz;
  if (!(ranges <= kMostRanges && readings <= kMostReadings)) {
    throw Error(
        ErrorKind::config,
        fmt::format("{}: {:.3g} s of driving make {:.3g} ranges and {:.3g} odometry readings; at most "
                    "50 million and 5 million are simulated",
                    scenario.path.name, duration_s, ranges, readings));
  }
  s.last_tick = static_cast<std::int64_t>(std::floor(duration_s * static_cast<double>(kTicksPerSecond)));
  return s;
}

/// Every leg of the path must be free in the map.
void check_path(const WaypointPath& path, const GridMap& map) {
  for (std::size_t k = 0; k < path.points.size(); ++k) {
    const Waypoint& b = path.points[k];
    if (map.at_point(b.x_m, b.y_m) != Cell::free) {
      throw input_error(
          path.name, 0,
          fmt::format("point {} ({}, {}) is not in a free cell of {}", k + 1, b.x_m, b.y_m, map.name));
    }
    if (k == 0) continue;
    const Waypoint& a = path.points[k - 1];
    const double dx = b.x_m - a.x_m;
    const double dy = b.y_m - a.y_m;
    const double length_m = std::sqrt(dx * dx + dy * dy);
    const SimulatedHit wall = cast_simulated_ray(map, a.x_m, a.y_m, portable_atan2_64(dy, dx), length_m);
    if (wall.hit) {
      const double part = wall.range_m / length_m;
      throw input_error(path.name, 0,
                        fmt::format("the way from point {} to point {} goes through a wall of {} at ({:.2f}, "
                                    "{:.2f})",
                                    k, k + 1, map.name, a.x_m + part * dx, a.y_m + part * dy));
    }
  }
}

/// The odometry's own idea of where it is: every true step, seen with error.
class SimulatedWheels {
 public:
  SimulatedWheels(const SimulatedOdometry& model, const Pose& truth, std::uint64_t seed)
      : model_(model), seed_(seed), truth_(truth), pose_(model.start) {}

  const Pose& pose() const { return pose_; }

  void move_to(const Pose& truth) {
    const Normals n = normals(philox(0, step_, Stream::simulated_odometry, 0, seed_));
    model_.errors == OdometryErrors::wheels ? roll(truth, n) : turn_drive_turn(truth, n);
    truth_ = truth;
    ++step_;
  }

 private:
  static double noise(float sigma, float n) { return static_cast<double>(sigma) * static_cast<double>(n); }

  void turn_drive_turn(const Pose& truth, const Normals& n) {
    // The truth is exact, so that the direction of a step far below min_translation_m still is one.
    constexpr double turn_in_place_m = 1e-9;
    const OdometryIncrement d = odometry_increment(truth_, truth, turn_in_place_m);
    const MotionStep sigma = motion_step(d, model_.noise);
    const double rot1 = model_.scale_rotation * d.rot1_rad + noise(sigma.sigma_rot1, n.n[0]);
    const double trans = model_.scale_translation * d.trans_m + noise(sigma.sigma_trans, n.n[1]);
    const double rot2 = model_.scale_rotation * d.rot2_rad + noise(sigma.sigma_rot2, n.n[2]);
    const SinCos64 a = portable_sincos64(pose_.theta_rad + rot1);
    pose_ = {pose_.x_m + trans * a.cos, pose_.y_m + trans * a.sin,
             wrap64(pose_.theta_rad + rot1 + rot2 + model_.drift_rad_per_m * d.trans_m)};
  }

  void roll(const Pose& truth, const Normals& n) {
    const double along_m = along_heading(truth_, truth);
    const double turn_rad = wrap64(truth.theta_rad - truth_.theta_rad);
    const WheelArcs arcs =
        wheel_arcs(model_.scale_translation * along_m,
                   model_.scale_rotation * turn_rad + model_.drift_rad_per_m * along_m, model_.wheel_base_m);
    pose_ = rolled(pose_,
                   with_error(arcs, model_.kappa_m, static_cast<double>(n.n[0]), static_cast<double>(n.n[1])),
                   model_.wheel_base_m);
  }

  const SimulatedOdometry& model_;
  std::uint64_t seed_;
  Pose truth_;
  Pose pose_;
  std::uint32_t step_ = 0;
};

float dropout_reading(DropoutValue value) {
  switch (value) {
    case DropoutValue::nan:
      return std::numeric_limits<float>::quiet_NaN();
    case DropoutValue::inf:
      return std::numeric_limits<float>::infinity();
    case DropoutValue::zero:
      break;
  }
  return 0.0f;
}

float over_range_reading(const SimulatedLidar& lidar) {
  switch (lidar.over_range) {
    case OverRange::inf:
      return std::numeric_limits<float>::infinity();
    case OverRange::code:
      return static_cast<float>(lidar.over_range_code_m);
    case OverRange::max:
      break;
  }
  return static_cast<float>(lidar.range_max_m);
}

/// Where and which way beam i of a scan looks, in the map frame.
struct TrueBeam {
  double x_m, y_m, angle_rad;
};

TrueBeam true_beam(const SimulatedLidar& lidar, const Drive& drive, double stamp_s, int beam) {
  double time_s = stamp_s;
  if (lidar.scan_time_s > 0.0 && lidar.beams > 1) {
    const double at_stamp = lidar.stamp_at == StampAt::first    ? 0.0
                            : lidar.stamp_at == StampAt::middle ? 0.5
                                                                : 1.0;
    time_s += lidar.scan_time_s * (beam / (lidar.beams - 1.0) - at_stamp);
  }
  const Pose sensor = compose(pose_at(drive, time_s), lidar.T_base_sensor);
  const double bearing_rad = lidar.angle_min_rad + beam * lidar.angle_step_rad;
  // Added up in this order: pinned logs have its rounding.
  const double angle_rad = lidar.upside_down
                               ? sensor.theta_rad - bearing_rad
                               : sensor.theta_rad + lidar.angle_min_rad + beam * lidar.angle_step_rad;
  return {sensor.x_m, sensor.y_m, angle_rad};
}

/// Scan number `index` of LiDAR number `which`; counts its beams in `log`.
Scan take_scan(const Scenario& scenario, const SimulatedLidar& lidar, std::uint32_t which, const GridMap& map,
               const ClutterField& clutter, const Drive& drive, double stamp_s, std::uint32_t index,
               SimulatedLog& log) {
  const Pose truth = pose_at(drive, stamp_s);
  Scan scan;
  scan.stamp_s = stamp_s;
  scan.sensor = fmt::format("robotlaser{}", which + 1);
  scan.T_base_sensor = lidar.T_base_sensor;
  scan.angle_min_rad = lidar.angle_min_rad;
  scan.angle_step_rad = lidar.angle_step_rad;
  scan.range_min_m = lidar.range_min_m;
  scan.range_max_m = lidar.range_max_m;
  scan.scan_time_s = lidar.scan_time_s;
  scan.ranges_m.resize(static_cast<std::size_t>(lidar.beams));
  for (int beam = 0; beam < lidar.beams; ++beam) {
    const TrueBeam b = true_beam(lidar, drive, stamp_s, beam);
    SimulatedHit wall = cast_simulated_ray(map, b.x_m, b.y_m, b.angle_rad, lidar.range_max_m);
    const double free_m = clutter.range(truth, stamp_s, b.x_m, b.y_m, b.angle_rad, wall.range_m);
    const bool unmapped = free_m < wall.range_m;
    if (unmapped) wall.range_m = free_m, wall.hit = true;
    const Philox4x32 r =
        philox(static_cast<std::uint32_t>(beam), index, Stream::simulated_beams, which, scenario.seed);
    const double sigma_m = lidar.sigma_range_m + lidar.sigma_range_relative * wall.range_m;
    const double range_m = wall.range_m + sigma_m * static_cast<double>(normals(r).n[0]);
    const bool lost = static_cast<double>(uniform_unit(r.w[2])) < lidar.dropout_probability;
    const bool out_of_reach = !wall.hit || range_m >= lidar.range_max_m;
    float& reading = scan.ranges_m[static_cast<std::size_t>(beam)];
    if (lost || (!out_of_reach && range_m < lidar.range_min_m)) {
      reading = dropout_reading(lidar.dropout_value);
      ++log.dropouts;
    } else if (out_of_reach) {
      reading = over_range_reading(lidar);
      ++log.over_range;
    } else {
      reading = static_cast<float>(range_m);
      ++log.hits;
      log.unmapped += unmapped ? 1 : 0;
    }
  }
  log.beams += static_cast<std::size_t>(lidar.beams);
  return scan;
}

}  // namespace

SimulatedLog simulate(const Scenario& scenario, const GridMap& map,
                      const std::function<bool(double fraction)>& keep_going) {
  validate(map);
  const Drive drive = plan_drive(scenario.path);
  const Schedule schedule = make_schedule(scenario, drive.duration_s());
  check_path(scenario.path, map);
  const ClutterField clutter(scenario, map);
  SimulatedLog log;
  log.path_length_m = path_length_m(scenario.path);
  log.duration_s = drive.duration_s();
  SimulatedWheels wheels(scenario.odometry, pose_at(drive, 0.0), scenario.seed);
  const std::vector<const SimulatedLidar*> lidars = all_lidars(scenario);
  for (std::int64_t tick = 0; tick <= schedule.last_tick; tick += schedule.odometry_ticks) {
    const double stamp_s = static_cast<double>(tick) / static_cast<double>(kTicksPerSecond);
    const Pose truth = pose_at(drive, stamp_s);
    if (tick > 0) wheels.move_to(pose_at(drive, stamp_s - scenario.odometry.delay_s));
    LogRecord record;
    record.stamp_s = stamp_s;
    record.odometry = wheels.pose();
    for (std::uint32_t k = 0; k < lidars.size(); ++k) {
      const std::int64_t since = tick - schedule.delay_ticks[k];
      if (since < 0 || since % schedule.scan_ticks != 0) continue;
      record.kind = RecordKind::scan;
      const auto index = static_cast<std::uint32_t>(since / schedule.scan_ticks);
      record.scan = take_scan(scenario, *lidars[k], k, map, clutter, drive, stamp_s, index, log);
      log.records.push_back(record);
    }
    const bool is_scan = record.kind == RecordKind::scan;
    if (is_scan) {
      log.truth.push_back({stamp_s, truth});
    } else {
      log.records.push_back(std::move(record));
    }
    const double fraction =
        static_cast<double>(tick) / std::max(1.0, static_cast<double>(schedule.last_tick));
    if (is_scan && keep_going && !keep_going(fraction)) break;
  }
  return log;
}

std::string carmen_text(const SimulatedLog& log) {
  std::string text =
      "# simulated by parloc: ROBOTLASER1 and ODOM x y theta tv rv accel stamp host logger_stamp\n";
  for (const LogRecord& record : log.records) {
    if (record.kind == RecordKind::scan) {
      text += carmen_line(record);
    } else {
      const Pose& pose = record.odometry;
      fmt::format_to(std::back_inserter(text), "ODOM {:.9f} {:.9f} {:.9f} 0 0 0 {:.6f} parloc {:.6f}",
                     pose.x_m, pose.y_m, pose.theta_rad, record.stamp_s, record.stamp_s);
    }
    text += '\n';
  }
  return text;
}

}  // namespace parloc
