// Scenarios, maps and sums for the tests of the simulator.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/map/map_reader.h"
#include "common/simulator/simulator.h"
#include "tests/unit/expect.h"

namespace parloc {

constexpr double kDeg = std::numbers::pi / 180.0;
inline const std::string kRoot = std::string(PARLOC_SOURCE_DIR) + "/";

inline Scenario paper() {
  return read_scenario(kRoot + "configs/paz2012_scenario.yaml");
}

/// No noise of any kind.
inline Scenario noise_free(Scenario s) {
  s.lidar.sigma_range_m = s.lidar.sigma_range_relative = s.lidar.dropout_probability = 0.0;
  s.odometry.noise.alpha1 = s.odometry.noise.alpha2 = s.odometry.noise.alpha3 = s.odometry.noise.alpha4 = 0.0;
  s.odometry.scale_translation = s.odometry.scale_rotation = 1.0;
  s.odometry.drift_rad_per_m = 0.0;
  return s;
}

inline const GridMap& fine_hall() {
  static const GridMap map = read_map(kRoot + "maps/fine/hall_obstacles.yaml");
  return map;
}

/// 17 m through the hall of the paper with its noise of odometry and ranges.
inline const SimulatedLog& hall_drive() {
  static const SimulatedLog log = [] {
    Scenario s = paper();
    s.seed = 3;
    return simulate(s, fine_hall());
  }();
  return log;
}
/// Its truth from where the first scan was taken, at the scans.
inline Trajectory truth_of_hall_drive() {
  Trajectory truth = hall_drive().truth;
  const Pose first = truth.front().pose;
  for (StampedPose& p : truth) p.pose = relative(p.pose, first);
  return truth;
}

/// An empty room of 30 x 4 m with walls, for drives along +x from (2, 2).
inline GridMap corridor() {
  std::vector<std::string> rows(40, "#" + std::string(298, '.') + "#");
  rows.front() = rows.back() = std::string(300, '#');
  return grid_from_text(rows, 0.1);
}
inline Scenario straight_10_m() {
  Scenario s = noise_free(Scenario{});
  s.path.name = "straight";
  s.path.points = {{2.0, 2.0, 0.0}, {12.0, 2.0, 0.0}};
  s.lidar.beams = 1;
  return s;
}

/// FNV-1a, to pin a text without keeping it.
inline std::uint64_t checksum(const std::string& text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

inline std::vector<LogRecord> scans_of(const SimulatedLog& log) {
  std::vector<LogRecord> scans;
  for (const LogRecord& record : log.records) {
    if (record.kind == RecordKind::scan) scans.push_back(record);
  }
  return scans;
}

inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}
inline double deviation(const std::vector<double>& values) {
  const double centre = mean(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - centre) * (v - centre);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Turns left on the spot at 1 rad/s in the corridor, from the first second to the seventh.
inline Scenario spin() {
  Scenario s = noise_free(Scenario{});
  s.path.name = "spin";
  s.path.points = {{3.0, 1.5, 1.0, 6.0}, {5.0, 1.5, 0.0}};
  s.path.turn_rate_rad_s = 1.0;
  s.lidar.T_base_sensor = {0.3, 0.1, 0.5};
  s.lidar.beams = 90;
  s.lidar.range_max_m = 50.0;
  s.lidar.scan_time_s = 0.1;
  return s;
}

}  // namespace parloc
