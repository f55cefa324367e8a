// Simulated logs: scans, odometry, noise, several LiDARs, that a seed means one log, and what is refused.
#include "common/simulator/simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "common/simulator/drive.h"
#include "tests/unit/simulated.h"

namespace parloc {
namespace {

// ---- scans --------------------------------------------------------------------------------------
TEST(Simulator, a_noise_free_scan_is_explained_by_the_truth) {
  Scenario scenario = noise_free(paper());
  scenario.scan_rate_hz = 1.0;
  const SimulatedLog log = simulate(scenario, fine_hall());
  const GridMap coarse = read_map(scenario.localization_map_path);
  std::vector<double> coarse_error_m;
  std::size_t checked = 0;
  std::size_t row = 0;
  for (const LogRecord& record : log.records) {
    if (record.kind != RecordKind::scan) continue;
    EXPECT_EQ(record.stamp_s, log.truth[row].stamp_s);
    const Pose sensor = compose(log.truth[row++].pose, record.scan.T_base_sensor);
    for (std::size_t beam = 0; beam < record.scan.ranges_m.size(); beam += 7) {
      const double range_m = static_cast<double>(record.scan.ranges_m[beam]);
      const double angle = sensor.theta_rad + record.scan.angle_min_rad +
                           static_cast<double>(beam) * record.scan.angle_step_rad;
      const auto cell_after = [&](double along_m) {
        return fine_hall().at_point(sensor.x_m + along_m * std::cos(angle),
                                    sensor.y_m + along_m * std::sin(angle));
      };
      // Free all the way in 5 mm steps, then a wall within the rounding of float32: 10 um, far below the 1 cm
      // asked for.
      for (double along_m = 0.0; along_m < range_m - 1e-5; along_m += 0.005)
        ASSERT_EQ(cell_after(along_m), Cell::free);
      if (range_m >= scenario.lidar.range_max_m) continue;
      EXPECT_EQ(cell_after(range_m + 1e-5), Cell::occupied);
      const SimulatedHit filters =
          cast_simulated_ray(coarse, sensor.x_m, sensor.y_m, angle, scenario.lidar.range_max_m);
      coarse_error_m.push_back(std::fabs(filters.range_m - range_m));
      ++checked;
    }
  }
  EXPECT_GT(checked, 2500u);
  // The filter's 5 cm map is a different one: ranges are off by millimetres to a cell, not by zero.
  std::nth_element(coarse_error_m.begin(), coarse_error_m.begin() + static_cast<long>(checked / 2),
                   coarse_error_m.end());
  EXPECT_GT(coarse_error_m[checked / 2], 0.003);
  EXPECT_LT(coarse_error_m[checked / 2], 0.03);
}

TEST(Simulator, range_noise_has_the_asked_spread) {
  const Scenario quiet = noise_free(paper());
  Scenario noisy = quiet;
  noisy.lidar.sigma_range_m = 0.02;
  noisy.lidar.range_min_m = 0.0;
  const SimulatedLog exact = simulate(quiet, fine_hall());
  const SimulatedLog log = simulate(noisy, fine_hall());
  ASSERT_EQ(exact.records.size(), log.records.size());
  std::vector<double> error_m;
  double neighbours = 0.0;  // of beams beside each other
  for (std::size_t k = 0; k < log.records.size(); ++k) {
    const auto& a = exact.records[k].scan.ranges_m;
    const auto& b = log.records[k].scan.ranges_m;
    for (std::size_t beam = 0; beam < a.size(); ++beam) {
      if (a[beam] > 7.8f) continue;  // 10 sigma from where noise turns a hit into over-range
      error_m.push_back(static_cast<double>(b[beam]) - static_cast<double>(a[beam]));
      if (beam > 0 && a[beam - 1] <= 7.8f) neighbours += error_m.back() * error_m[error_m.size() - 2];
    }
  }
  // 4 standard errors: a sound generator fails with probability 6e-5 for one seed; the seed is fixed.
  const double n = static_cast<double>(error_m.size());
  ASSERT_GT(n, 1e5);
  EXPECT_NEAR(mean(error_m), 0.0, 4.0 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(deviation(error_m), 0.02, 4.0 * 0.02 / std::sqrt(2.0 * n));
  EXPECT_NEAR(neighbours / n / (0.02 * 0.02), 0.0, 4.0 / std::sqrt(n));
}

TEST(Simulator, relative_noise_grows_with_the_range) {
  Scenario s = straight_10_m();
  s.lidar.beams = 361;
  s.lidar.range_max_m = 20.0;
  const SimulatedLog exact = simulate(s, corridor());
  s.lidar.sigma_range_relative = 0.01;
  const SimulatedLog log = simulate(s, corridor());
  std::vector<double> z;
  for (std::size_t k = 0; k < log.records.size(); ++k) {
    for (std::size_t beam = 0; beam < log.records[k].scan.ranges_m.size(); ++beam) {
      const double r = static_cast<double>(exact.records[k].scan.ranges_m[beam]);
      if (r < 18.0) z.push_back((static_cast<double>(log.records[k].scan.ranges_m[beam]) - r) / (0.01 * r));
    }
  }
  EXPECT_NEAR(deviation(z), 1.0, 4.0 / std::sqrt(2.0 * static_cast<double>(z.size())));  // 4 standard errors
}

TEST(Simulator, drop_outs_are_counted_and_come_as_asked) {
  for (const DropoutValue value : {DropoutValue::zero, DropoutValue::nan, DropoutValue::inf}) {
    Scenario s = paper();
    s.lidar.dropout_probability = 0.03;
    s.lidar.dropout_value = value;
    s.scan_rate_hz = 2.0;
    const SimulatedLog log = simulate(s, fine_hall());
    std::size_t found = 0, over = 0, beams = 0;
    for (const LogRecord& record : log.records) {
      for (const float r : record.scan.ranges_m) {
        found += value == DropoutValue::zero  ? r == 0.0f
                 : value == DropoutValue::nan ? std::isnan(r)
                                              : std::isinf(r);
        over += r == 8.0f;
        ++beams;
      }
    }
    EXPECT_EQ(found, log.dropouts);
    EXPECT_EQ(over, log.over_range);
    EXPECT_EQ(beams, log.beams);
    EXPECT_EQ(log.beams, log.hits + log.over_range + log.dropouts);
    // No wall of the path is within range_min, so the drop-outs are binomial: 4 standard errors.
    const double n = static_cast<double>(log.beams);
    EXPECT_NEAR(static_cast<double>(log.dropouts) / n, 0.03, 4.0 * std::sqrt(0.03 * 0.97 / n));
  }
}

TEST(Simulator, over_range_beams_come_as_asked) {
  Scenario s = straight_10_m();  // its one beam looks at -90 degrees, 1.9 m from the wall
  s.lidar.range_max_m = 1.5;
  s.lidar.sigma_range_m = 0.0;
  for (const auto& [value, expected] :
       {std::pair{OverRange::max, 1.5f}, {OverRange::inf, INFINITY}, {OverRange::code, 81.83f}}) {
    s.lidar.over_range = value;
    const SimulatedLog log = simulate(s, corridor());
    EXPECT_EQ(log.over_range, log.beams);
    for (const LogRecord& record : log.records) {
      for (const float r : record.scan.ranges_m) EXPECT_EQ(r, expected);
    }
  }
  s.lidar.range_max_m = 5.0;
  s.lidar.range_min_m = 2.0;  // too close
  EXPECT_EQ(simulate(s, corridor()).dropouts, simulate(s, corridor()).beams);
}

// ---- odometry -----------------------------------------------------------------------------------
TEST(Simulator, odometry_without_noise_is_the_truth_in_its_own_frame) {
  Scenario s = noise_free(paper());
  s.odometry.start = {100.0, -50.0, 2.0};
  s.scan_rate_hz = 5.0;
  const SimulatedLog log = simulate(s, fine_hall());
  const std::vector<LogRecord> scans = scans_of(log);
  ASSERT_EQ(scans.size(), log.truth.size());
  for (std::size_t k = 0; k < log.truth.size(); ++k) {
    const Pose truth = relative(log.truth[k].pose, log.truth[0].pose);
    expect_near(truth, relative(scans[k].odometry, s.odometry.start), 1e-9, 1e-9);
  }
}

/// Where the odometry of a 10 m drive ends, seen from where it should, for many seeds.
std::vector<Pose> final_errors(Scenario s, int seeds) {
  std::vector<Pose> errors;
  const GridMap map = corridor();
  for (int seed = 1; seed <= seeds; ++seed) {
    s.seed = static_cast<std::uint64_t>(seed);
    const SimulatedLog log = simulate(s, map);
    errors.push_back(relative(log.records.back().odometry, {10.0, 0.0, 0.0}));
  }
  return errors;
}

TEST(Simulator, odometry_noise_follows_the_seed_form) {
  // 400 steps of 2.5 cm. Tolerance: 4 standard errors of a standard deviation from 300 runs, 16 %.
  const double tolerance = 4.0 / std::sqrt(2.0 * 300.0);
  Scenario s = straight_10_m();
  s.odometry.noise.alpha3 = 0.1;
  std::vector<double> along_m, across_m, heading;
  for (const Pose& e : final_errors(s, 300)) {
    along_m.push_back(e.x_m);
    across_m.push_back(e.y_m);
  }
  const double sigma_m = 0.1 * 0.025 * std::sqrt(400.0);
  EXPECT_NEAR(deviation(along_m), sigma_m, tolerance * sigma_m);
  EXPECT_NEAR(mean(along_m), 0.0, 4.0 * sigma_m / std::sqrt(300.0));
  EXPECT_LT(deviation(across_m), 1e-9);

  s.odometry.noise.alpha3 = 0.0;
  s.odometry.noise.alpha2 = 0.05;
  for (const Pose& e : final_errors(s, 300)) heading.push_back(e.theta_rad);
  const double sigma_rad = 0.05 * 0.025 * std::sqrt(2.0 * 400.0);  // rot1 and rot2 of every step
  EXPECT_NEAR(deviation(heading), sigma_rad, tolerance * sigma_rad);
}

TEST(Simulator, systematic_errors_are_exact) {
  Scenario s = straight_10_m();
  s.odometry.scale_translation = 1.02;
  EXPECT_NEAR(final_errors(s, 1)[0].x_m, 0.2, 1e-9);
  s.odometry.scale_translation = 1.0;
  s.odometry.drift_rad_per_m = 0.01;
  EXPECT_NEAR(final_errors(s, 1)[0].theta_rad, 0.1, 1e-9);
  s = noise_free(paper());
  // Left, right, left, right: 53.13, -53.13, 90, -90 degrees cancel; seen in between.
  s.odometry.scale_rotation = 1.1;
  const SimulatedLog log = simulate(s, fine_hall());
  double largest = 0.0;
  for (const LogRecord& record : log.records) largest = std::max(largest, record.odometry.theta_rad);
  EXPECT_NEAR(largest, 1.1 * 90.0 * kDeg, 1e-9);
}

// ---- scans that take time, several LiDARs --------------------------------------------------------
TEST(Simulator, every_beam_is_cast_from_where_the_robot_is_at_its_time) {
  for (const auto& [at, before_s] :
       {std::pair{StampAt::first, 0.0}, {StampAt::middle, 0.05}, {StampAt::last, 0.1}}) {
    Scenario s = spin();
    s.lidar.stamp_at = at;
    const GridMap map = corridor();
    int checked = 0;
    for (const LogRecord& record : scans_of(simulate(s, map))) {
      if (record.stamp_s < 1.2 || record.stamp_s > 6.8) continue;
      EXPECT_EQ(record.scan.scan_time_s, 0.1);
      for (std::size_t i = 0; i < 90; i += 13) {
        const double t = record.stamp_s - before_s + 0.1 * static_cast<double>(i) / 89.0;
        const double heading = t - 1.0;  // 1 rad/s from 1 s on
        const double x = 3.0 + 0.3 * std::cos(heading) - 0.1 * std::sin(heading);
        const double y = 1.5 + 0.3 * std::sin(heading) + 0.1 * std::cos(heading);
        const double angle = heading + 0.5 - std::numbers::pi / 2.0 + 0.5 * kDeg * static_cast<double>(i);
        const double range_m = cast_simulated_ray(map, x, y, angle, 50.0).range_m;
        // Rounding; a beam along the corridor at a grazing angle magnifies it.
        EXPECT_NEAR(record.scan.ranges_m[i], range_m, 1e-5);
        ++checked;
      }
    }
    EXPECT_GT(checked, 300);
  }
}

TEST(Simulator, upside_down_is_mirrored) {
  Scenario s = spin();
  s.lidar.angle_min_rad = -0.4;
  s.lidar.upside_down = true;
  Scenario mirrored = spin();
  mirrored.lidar.angle_min_rad = 0.4;
  mirrored.lidar.angle_step_rad = -s.lidar.angle_step_rad;
  const GridMap map = corridor();
  const std::vector<LogRecord> a = scans_of(simulate(s, map)), b = scans_of(simulate(mirrored, map));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].scan.angle_min_rad, -0.4);  // as the device says it
    for (std::size_t i = 0; i < 90; ++i) EXPECT_NEAR(a[k].scan.ranges_m[i], b[k].scan.ranges_m[i], 1e-5);
  }
}

TEST(Simulator, several_lidars_scan_each_on_its_own) {
  Scenario s = straight_10_m();
  s.lidar.beams = 30;
  s.lidar.sigma_range_m = 0.02;
  const SimulatedLog alone = simulate(s, corridor());
  SimulatedLidar rear = s.lidar;
  rear.beams = 20;
  rear.T_base_sensor = {-0.2, 0.0, -3.0};
  SimulatedLidar late = rear;
  late.delay_s = 0.05;
  s.more_lidars = {rear, late};
  const SimulatedLog log = simulate(s, corridor());
  std::vector<std::vector<LogRecord>> by_lidar(3);
  for (const LogRecord& record : scans_of(log)) {
    ASSERT_EQ(record.scan.sensor.substr(0, 10), "robotlaser");
    by_lidar.at(static_cast<std::size_t>(record.scan.sensor.back() - '1')).push_back(record);
  }
  const std::vector<LogRecord> first = scans_of(alone);
  ASSERT_EQ(by_lidar[0].size(), first.size());
  ASSERT_EQ(by_lidar[1].size(), first.size());
  ASSERT_GE(by_lidar[2].size(), first.size() - 1);
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(by_lidar[0][k].scan.ranges_m, first[k].scan.ranges_m);  // the others do not change it
    EXPECT_EQ(by_lidar[1][k].stamp_s, first[k].stamp_s);
    EXPECT_EQ(by_lidar[1][k].odometry.x_m, first[k].odometry.x_m);
    EXPECT_EQ(by_lidar[1][k].scan.ranges_m.size(), 20u);
    if (k < by_lidar[2].size()) {
      EXPECT_NEAR(by_lidar[2][k].stamp_s, first[k].stamp_s + 0.05, 1e-12);
    }
  }
  // Noise of its own, not that of the other LiDAR: both look at the same wall with beam 0 if mounted alike.
  EXPECT_NE(by_lidar[1][0].scan.ranges_m[0], by_lidar[0][0].scan.ranges_m[0]);
  for (std::size_t k = 1; k < log.truth.size(); ++k)
    EXPECT_LT(log.truth[k - 1].stamp_s, log.truth[k].stamp_s);
  EXPECT_EQ(log.beams, 30 * by_lidar[0].size() + 20 * (by_lidar[1].size() + by_lidar[2].size()));

  const auto reader = carmen_log_from_text(carmen_text(log), "simulated");
  LogRecord read;
  for (const LogRecord& written : log.records) {
    ASSERT_TRUE(reader->next(read));
    EXPECT_EQ(read.kind, written.kind);
    if (written.kind != RecordKind::scan) continue;
    EXPECT_EQ(read.scan.sensor, written.scan.sensor);
    EXPECT_EQ(read.scan.ranges_m.size(), written.scan.ranges_m.size());
    EXPECT_NEAR(read.scan.T_base_sensor.theta_rad, written.scan.T_base_sensor.theta_rad, 1e-8);
  }
  EXPECT_EQ(reader->warnings().beam_count_changes, 0u);  // counted by LiDAR
}

}  // namespace
}  // namespace parloc
