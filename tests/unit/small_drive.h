// A small room with a robot that drives through it: a map, a log without noise, and its truth, for tests.
#pragma once

#include <cmath>

#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/map/grid_map.h"
#include "common/simulator/simulator.h"

namespace parloc::test {

/// 6 x 4 m in cells of 10 cm, walls around, a pillar that breaks the symmetry.
inline GridMap small_room() {
  std::vector<std::string> rows(40, "#" + std::string(58, '.') + "#");
  rows.front() = rows.back() = std::string(60, '#');
  for (int j = 8; j < 14; ++j) rows[j].replace(40, 5, "#####");
  return grid_from_text(rows, 0.1);
}

struct SmallDrive {
  std::vector<LogRecord> scans;
  Trajectory truth;
};

/// `count` scans of 61 beams over 240 degrees, 10 per second from stamp 100 s, on a quarter circle in the
/// room that starts at (1, 1, 0); the odometry starts at its own origin and is exact.
inline SmallDrive small_drive(const GridMap& room, int count) {
  SmallDrive drive;
  const Pose start{1.0, 1.0, 0.0};
  for (int k = 0; k < count; ++k) {
    const double turned_rad = 1.5 * k / count, radius_m = 1.5;
    const Pose pose{start.x_m + radius_m * std::sin(turned_rad),
                    start.y_m + radius_m * (1.0 - std::cos(turned_rad)), turned_rad};
    LogRecord record;
    record.kind = RecordKind::scan;
    record.stamp_s = record.scan.stamp_s = 100.0 + 0.1 * k;
    record.odometry = relative(pose, start);
    record.scan.sensor = "robotlaser1";
    record.scan.angle_step_rad = 4.0 * M_PI / 3.0 / 60.0;
    record.scan.angle_min_rad = -30.0 * record.scan.angle_step_rad;
    record.scan.range_max_m = 8.0;
    for (int i = 0; i < 61; ++i) {
      const double angle_rad = pose.theta_rad + record.scan.angle_min_rad + i * record.scan.angle_step_rad;
      record.scan.ranges_m.push_back(
          static_cast<float>(cast_simulated_ray(room, pose.x_m, pose.y_m, angle_rad, 8.0).range_m));
    }
    drive.scans.push_back(record);
    drive.truth.push_back({record.stamp_s, pose});
  }
  return drive;
}

inline std::string carmen_log_of(const SmallDrive& drive) {
  std::string text;
  for (const LogRecord& record : drive.scans) text += carmen_line(record) + "\n";
  return text;
}

}  // namespace parloc::test
