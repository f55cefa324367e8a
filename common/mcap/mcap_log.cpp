#include "common/mcap/mcap_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/error.h"
#include "common/ros/message_definitions.h"

namespace parloc {

namespace {

/// Logs state where a LiDAR is with as few as 6 decimals, of poses in the world: differences jitter by so
/// much.
constexpr double kSamePlace = 1e-5;  // [m], [rad]

/// Angles that run clockwise are those of a LiDAR that is mounted upside down.
bool runs_clockwise(const Scan& scan) {
  return scan.ranges_m.size() > 1 && scan.angle_step_rad < 0.0;
}

}  // namespace

std::string laser_frame(const std::string& sensor) {
  return sensor.empty() ? "laser" : "laser_" + sensor;
}

LaserScanMessage laser_scan_message(const Scan& scan) {
  const char* uneven = !scan.bearings_rad.empty() ? "angles" : !scan.beam_times_s.empty() ? "times" : nullptr;
  if (uneven != nullptr)
    throw Error(ErrorKind::input,
                fmt::format("{} has {} for each beam: expected even ones, which is all that a "
                            "sensor_msgs/LaserScan holds",
                            printable(scan.sensor), uneven));
  const double sign = runs_clockwise(scan) ? -1.0 : 1.0;
  const double gaps = scan.ranges_m.empty() ? 0.0 : static_cast<double>(scan.ranges_m.size() - 1);
  LaserScanMessage message;
  message.header = {scan.stamp_s, laser_frame(scan.sensor)};
  message.angle_min_rad = static_cast<float>(sign * scan.angle_min_rad);
  message.angle_step_rad = static_cast<float>(sign * scan.angle_step_rad);
  message.angle_max_rad = static_cast<float>(sign * (scan.angle_min_rad + gaps * scan.angle_step_rad));
  message.time_step_s = gaps > 0.0 ? static_cast<float>(scan.scan_time_s / gaps) : 0.0f;
  message.range_min_m = static_cast<float>(scan.range_min_m);
  // Not known: viewers leave out what is beyond it.
  message.range_max_m =
      scan.range_max_m > 0.0 ? static_cast<float>(scan.range_max_m) : std::numeric_limits<float>::infinity();
  message.ranges_m = scan.ranges_m;
  return message;
}

McapLog::McapLog(McapWriter::Sink sink, double longest_chunk_s) : writer_(std::move(sink), longest_chunk_s) {}

void McapLog::write(const std::string& topic, const char* type, double stamp_s, const MessageWriter& message,
                    bool latched) {
  auto known = topics_.find(topic);
  if (known == topics_.end())
    known = topics_.emplace(topic, writer_.add_topic({topic, type, message_definition(type), latched})).first;
  latest_ns_ = std::max(latest_ns_, ros_time(stamp_s).since_1970_ns());
  writer_.write(known->second, latest_ns_, message.bytes());
  ++messages_;
}

void McapLog::write_transforms(double stamp_s, const std::vector<TransformMessage>& transforms) {
  write("/tf", "tf2_msgs/msg/TFMessage", stamp_s, parloc::write_transforms(transforms));
}

void McapLog::write_odometry(double stamp_s, const Pose& odometry) {
  const OdometryMessage message{{stamp_s, kOdometry}, kBase, spatial(odometry)};
  write_transforms(stamp_s, {{message.header, message.child_frame, message.pose}});
  write("/odom", "nav_msgs/msg/Odometry", stamp_s, parloc::write_odometry(message));
}

void McapLog::write_scan(const std::string& topic, const Scan& scan) {
  const LaserScanMessage message = laser_scan_message(scan);
  write_mount(scan.sensor, scan.stamp_s, scan.T_base_sensor, scan.upside_down != runs_clockwise(scan));
  write(topic, "sensor_msgs/msg/LaserScan", scan.stamp_s, write_laser_scan(message));
}

void McapLog::write_mount(const std::string& sensor, double stamp_s, const Pose& T_base_sensor,
                          bool upside_down) {
  const auto [at, is_new] = mounts_.try_emplace(sensor);
  Mount& mount = at->second;
  const auto differs = [](double a, double b) { return !(std::fabs(a - b) <= kSamePlace); };
  mount.moves =
      !is_new && (mount.moves || differs(mount.first.x_m, T_base_sensor.x_m) ||
                  differs(mount.first.y_m, T_base_sensor.y_m) ||
                  differs(turn_rad(mount.first, T_base_sensor), 0.0) || mount.upside_down != upside_down);
  if (!is_new && !mount.moves) return;
  TransformMessage transform{{stamp_s, kBase}, laser_frame(sensor), spatial(T_base_sensor, upside_down)};
  if (mount.moves) return write_transforms(stamp_s, {transform});
  mount.first = T_base_sensor;
  mount.upside_down = upside_down;
  mount.transform = std::move(transform);
  // Who comes late gets the last message alone: each has all that is known.
  std::vector<TransformMessage> all;
  for (const auto& [name, known] : mounts_) all.push_back(known.transform);
  write("/tf_static", "tf2_msgs/msg/TFMessage", stamp_s, parloc::write_transforms(all), true);
}

std::vector<std::string> McapLog::moving() const {
  std::vector<std::string> names;
  for (const auto& [name, mount] : mounts_)
    if (mount.moves) names.push_back(name);
  return names;
}

}  // namespace parloc
