// A small map that looks different everywhere, one that does not, and drives through them.
#pragma once

#include <cmath>

#include "common/eval/trial.h"
#include "common/localize/localizer.h"

namespace parloc::test {

/// Two rooms and a corridor, 14 x 9 m in cells of 10 cm, with columns at no regular places.
inline GridMap two_rooms() {
  std::vector<std::string> rows(90, "#" + std::string(138, '.') + "#");
  rows.front() = rows.back() = std::string(140, '#');
  const auto fill = [&](int i, int j, int width, int height) {
    for (int y = j; y < j + height; ++y) rows[y].replace(i, width, std::string(width, '#'));
  };
  fill(0, 55, 60, 2), fill(75, 55, 65, 2);  // a wall with a door
  fill(62, 57, 2, 20);                      // and one across, open at its end
  fill(20, 15, 6, 4), fill(100, 30, 4, 12), fill(30, 70, 12, 4), fill(120, 75, 5, 5), fill(50, 35, 3, 3);
  return grid_from_text(rows, 0.1);
}

/// Nothing but four walls, 8 x 5 m: the same after half a turn.
inline GridMap bare_room() {
  std::vector<std::string> rows(50, "#" + std::string(78, '.') + "#");
  rows.front() = rows.back() = std::string(80, '#');
  return grid_from_text(rows, 0.1);
}

/// 181 beams all around that reach 6 m, 5 scans per second.
inline Scenario small_robot() {
  Scenario s;
  s.scan_rate_hz = 5.0;
  s.lidar.beams = 181;
  s.lidar.angle_min_rad = -M_PI;
  s.lidar.angle_step_rad = 2.0 * M_PI / 181.0;
  s.lidar.range_max_m = 6.0;
  return s;
}

/// Equal seeds give equal drives, `kidnap` puts the robot elsewhere after `duration_s`.
inline TrialLog drive(const GridMap& map, TrialTask task, double duration_s, std::uint64_t seed) {
  TrialPlan plan;
  plan.task = task;
  plan.duration_s = duration_s;
  return simulate_trial(plan, small_robot(), map, WanderArea(map, 0.4), seed);
}

inline LocalizerConfig small_localizer(int threads = 1) {
  LocalizerConfig c;
  c.particles = 600;
  c.backend = BackendChoice::cpu;
  c.threads = threads;
  c.scan.max_beams = 60;
  return c;
}

/// What it says at every scan.
inline std::vector<LocalizerEstimate> feed(Localizer& localizer, const std::vector<LogRecord>& records) {
  std::vector<LocalizerEstimate> said;
  for (const LogRecord& r : records) {
    localizer.add_odometry(r.stamp_s, r.odometry);
    if (r.kind == RecordKind::scan) said.push_back(localizer.step(r.odometry, r.scan));
  }
  return said;
}

}  // namespace parloc::test
