// The log that a simulation gives: the same everywhere, and read back as it was; and what cannot be
// simulated.
#include <gtest/gtest.h>

#include "common/simulator/drive.h"
#include "common/simulator/simulator.h"
#include "tests/unit/simulated.h"

namespace parloc {
namespace {

// ---- one seed, one log --------------------------------------------------------------------------
TEST(Simulator, a_seed_means_one_log) {
  Scenario s = paper();
  s.scan_rate_hz = 1.0;
  const std::string first = carmen_text(simulate(s, fine_hall()));
  EXPECT_EQ(first, carmen_text(simulate(s, fine_hall())));
  s.seed = 2;
  EXPECT_NE(first, carmen_text(simulate(s, fine_hall())));
  s.seed = 1 + (std::uint64_t{1} << 40);  // the high word counts too
  EXPECT_NE(first, carmen_text(simulate(s, fine_hall())));
}

TEST(Simulator, a_log_is_the_same_on_every_machine) {
  Scenario s;
  s.path.name = "bend";
  s.path.points = {{2.0, 2.0, 0.1}, {5.0, 1.0, 0.0}, {6.0, 3.0, 0.3}};
  s.lidar.dropout_probability = 0.05;
  EXPECT_EQ(checksum(carmen_text(simulate(s, corridor()))), 8466473242866925557u);
}

TEST(Simulator, the_log_reads_back) {
  Scenario s = paper();
  s.scan_rate_hz = 2.0;
  s.lidar.dropout_value = DropoutValue::nan;
  s.lidar.over_range = OverRange::inf;
  const SimulatedLog log = simulate(s, fine_hall());
  const auto reader = carmen_log_from_text(carmen_text(log), "simulated");
  LogRecord read;
  for (const LogRecord& written : log.records) {
    ASSERT_TRUE(reader->next(read));
    EXPECT_EQ(read.kind, written.kind);
    EXPECT_EQ(read.stamp_s, written.stamp_s);  // 5 ms survive 6 decimals
    EXPECT_NEAR(read.odometry.x_m, written.odometry.x_m, 1e-9);
    EXPECT_NEAR(read.odometry.theta_rad, written.odometry.theta_rad, 1e-9);
    if (written.kind != RecordKind::scan) continue;
    EXPECT_NEAR(read.scan.T_base_sensor.x_m, written.scan.T_base_sensor.x_m, 1e-8);
    EXPECT_NEAR(read.scan.angle_min_rad, written.scan.angle_min_rad, 1e-9);
    EXPECT_NEAR(read.scan.angle_step_rad, written.scan.angle_step_rad, 1e-9);
    EXPECT_NEAR(read.scan.range_max_m, written.scan.range_max_m, 1e-6);
    ASSERT_EQ(read.scan.ranges_m.size(), written.scan.ranges_m.size());
    for (std::size_t k = 0; k < read.scan.ranges_m.size(); ++k) {
      const float a = read.scan.ranges_m[k], b = written.scan.ranges_m[k];
      EXPECT_TRUE((std::isnan(a) && std::isnan(b)) || a == b || std::fabs(a - b) < 6e-5f);  // 4 decimals
    }
  }
  EXPECT_FALSE(reader->next(read));
  EXPECT_EQ(reader->warnings().broken_lines + reader->warnings().unknown_messages, 0u);
}

TEST(Simulator, stops_when_told) {
  const SimulatedLog log = simulate(paper(), fine_hall(), [](double fraction) { return fraction < 0.1; });
  EXPECT_NEAR(log.records.back().stamp_s, 0.1 * log.duration_s, 0.11);
  EXPECT_EQ(log.truth.size(), scans_of(log).size());
}

TEST(Simulator, stamps_are_multiples_of_5_ms_and_odometry_comes_between_scans) {
  const SimulatedLog log = simulate(paper(), fine_hall());
  for (std::size_t k = 0; k < log.records.size(); ++k) {
    EXPECT_EQ(log.records[k].stamp_s, static_cast<double>(k * 10) / 200.0);
    EXPECT_EQ(log.records[k].kind, k % 2 == 0 ? RecordKind::scan : RecordKind::odometry);
  }
  EXPECT_EQ(log.truth.size(), (log.records.size() + 1) / 2);
}

// ---- what is refused ----------------------------------------------------------------------------
TEST(Simulator, refuses_a_path_through_walls) {
  Scenario s = straight_10_m();
  s.path.points[1] = {2.0, 5.0, 0.0};
  expect_parts(error_of([&] { simulate(s, corridor()); }), {"point 2"});
  GridMap map = corridor();
  for (int j = 0; j < map.height; ++j)
    map.cells[static_cast<std::size_t>(j * map.width + 60)] = Cell::occupied;
  s = straight_10_m();
  expect_parts(error_of([&] { simulate(s, map); }), {"wall"});
}

std::string config_error(const Scenario& s) {
  return error_of([&] { simulate(s, corridor()); }, ErrorKind::config);
}

TEST(Simulator, refuses_rates_that_do_not_fit_and_drives_without_end) {
  Scenario s = straight_10_m();
  s.scan_rate_hz = 7.0;
  expect_parts(config_error(s), {"5 ms"});
  s.scan_rate_hz = 40.0;
  expect_parts(config_error(s), {"multiple"});
  s = straight_10_m();
  s.path.speed_mps = 1e-9;
  expect_parts(config_error(s), {"million"});
}

TEST(Simulator, refuses_times_that_do_not_fit) {
  Scenario s = straight_10_m();
  s.lidar.scan_time_s = 0.11;
  expect_parts(config_error(s), {"at most the 0.1 s between"});
  s = straight_10_m();
  s.more_lidars = {s.lidar};
  s.more_lidars[0].delay_s = 0.02;
  expect_parts(config_error(s), {"multiple of the odometry's period"});
}

}  // namespace
}  // namespace parloc
