// The simulator: its ray caster against SPEC 2.2, the drive, the noise, and that a seed means one log.
#include "common/eval/simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/eval/drive.h"
#include "common/map/map_reader.h"

namespace parloc {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;
const std::string kRoot = std::string(PARLOC_SOURCE_DIR) + "/";

Scenario paper() {
  return read_scenario(kRoot + "configs/paz2012_scenario.yaml");
}

/// No noise of any kind.
Scenario noise_free(Scenario s) {
  s.lidar.sigma_range_m = s.lidar.sigma_range_relative = s.lidar.dropout_probability = 0.0;
  s.odometry.noise.alpha1 = s.odometry.noise.alpha2 = s.odometry.noise.alpha3 = s.odometry.noise.alpha4 = 0.0;
  s.odometry.scale_translation = s.odometry.scale_rotation = 1.0;
  s.odometry.drift_rad_per_m = 0.0;
  return s;
}

const GridMap& fine_hall() {
  static const GridMap map = read_map(kRoot + "maps/fine/hall_obstacles.yaml");
  return map;
}

/// An empty room of 30 x 4 m with walls, for drives along +x from (2, 2).
GridMap corridor() {
  std::vector<std::string> rows(40, "#" + std::string(298, '.') + "#");
  rows.front() = rows.back() = std::string(300, '#');
  return grid_from_text(rows, 0.1);
}
Scenario straight_10_m() {
  Scenario s = noise_free(Scenario{});
  s.path.name = "straight";
  s.path.points = {{2.0, 2.0, 0.0}, {12.0, 2.0, 0.0}};
  s.lidar.beams = 1;
  return s;
}

/// FNV-1a, to pin a text without keeping it.
std::uint64_t checksum(const std::string& text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

std::vector<LogRecord> scans_of(const SimulatedLog& log) {
  std::vector<LogRecord> scans;
  for (const LogRecord& record : log.records) {
    if (record.kind == RecordKind::scan) scans.push_back(record);
  }
  return scans;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}
double deviation(const std::vector<double>& values) {
  const double centre = mean(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - centre) * (v - centre);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// ---- the ray caster -----------------------------------------------------------------------------
/// Test map T1 (SPEC 0.2): 10 x 8 cells of 0.5 m at (-1, -2), a wall around it, and cells (6, 4) and (3, 2).
GridMap t1() {
  return grid_from_text({"##########",   //
                         "#........#",   //
                         "#........#",   //
                         "#.....#..#",   //
                         "#........#",   //
                         "#..#.....#",   //
                         "#........#",   //
                         "##########"},  //
                        0.5, {-1.0, -2.0, 0.0});
}

TEST(SimulatedRay, meets_the_table_of_the_specification) {
  struct Row {
    double x_m, angle_deg, range_m;
    int i, j;
  };
  const Row rows[] = {{0.8, 0, 1.2, 6, 4},
                      {0.8, 30, 2.7, 8, 7},
                      {0.8, 45, 1.909188309204, 6, 7},
                      {0.8, 90, 1.35, 3, 7},
                      {0.8, 135, 1.838477631085, 0, 6},
                      {0.8, 180, 1.3, 0, 4},
                      {0.8, 200, 1.383431104219, 0, 3},
                      {0.8, 270, 0.65, 3, 2},
                      {0.8, 300, 1.905255888326, 5, 0},
                      {0.8, 333, 3.030280841613, 9, 1},
                      {0.5, 180, 1.0, 0, 4},
                      {0.5, 0, 1.5, 6, 4}};
  const GridMap map = t1();
  for (const Row& row : rows) {
    const SimulatedHit hit = cast_simulated_ray(map, row.x_m, 0.15, row.angle_deg * kDeg, 10.0);
    EXPECT_TRUE(hit.hit) << row.angle_deg;
    EXPECT_NEAR(hit.range_m, row.range_m, 1e-12) << row.angle_deg;  // the table has 12 decimals
    EXPECT_EQ(hit.i, row.i) << row.angle_deg;
    EXPECT_EQ(hit.j, row.j) << row.angle_deg;
  }
}

TEST(SimulatedRay, misses_beyond_its_reach_and_outside_the_grid) {
  const GridMap map = t1();
  const SimulatedHit near = cast_simulated_ray(map, 0.8, 0.15, 0.0, 1.19);
  EXPECT_FALSE(near.hit);
  EXPECT_EQ(near.range_m, 1.19);
  const SimulatedHit inside = cast_simulated_ray(map, 2.2, 0.2, 1.0, 10.0);  // starts in cell (6, 4)
  EXPECT_TRUE(inside.hit);
  EXPECT_EQ(inside.range_m, 0.0);
  EXPECT_FALSE(cast_simulated_ray(map, -1.5, 0.15, 0.0, 10.0).hit);
  EXPECT_FALSE(cast_simulated_ray(map, std::nan(""), 0.15, 0.0, 10.0).hit);
  const GridMap open = grid_from_text({"..", "??"}, 0.5);
  EXPECT_FALSE(cast_simulated_ray(open, 0.2, 0.7, -1.2, 10.0).hit);  // unknown cells stop nothing
}

TEST(SimulatedRay, knows_a_turned_grid) {
  const GridMap straight = t1();
  GridMap turned = straight;
  turned.T_map_grid = {3.0, -2.0, 0.7};
  for (int k = 0; k < 36; ++k) {
    const Pose in_grid = relative({0.8, 0.15, 0.3 + k * 10.0 * kDeg}, straight.T_map_grid);
    const Pose in_map = compose(turned.T_map_grid, in_grid);
    EXPECT_NEAR(cast_simulated_ray(turned, in_map.x_m, in_map.y_m, in_map.theta_rad, 10.0).range_m,
                cast_simulated_ray(straight, 0.8, 0.15, 0.3 + k * 10.0 * kDeg, 10.0).range_m, 1e-12);
  }
}

// ---- the drive ----------------------------------------------------------------------------------
TEST(Drive, the_papers_path_is_17_m_long) {
  const Scenario scenario = paper();
  EXPECT_NEAR(path_length_m(scenario.path), 17.0, 0.02 * 17.0);
  double driven_m = 0.0;
  const SimulatedLog log = simulate(scenario, fine_hall());
  for (std::size_t k = 1; k < log.truth.size(); ++k) {
    driven_m += std::hypot(log.truth[k].pose.x_m - log.truth[k - 1].pose.x_m,
                           log.truth[k].pose.y_m - log.truth[k - 1].pose.y_m);
  }
  EXPECT_NEAR(driven_m, 17.0, 0.02 * 17.0);
}

TEST(Drive, stops_to_turn) {
  const Scenario scenario = paper();
  const Drive drive = plan_drive(scenario.path);
  int turns = 0;
  for (const DrivePhase& phase : drive.phases) {
    const bool moves = phase.dx_m != 0.0 || phase.dy_m != 0.0;
    EXPECT_FALSE(moves && phase.turn_rad != 0.0);
    turns += phase.turn_rad != 0.0 ? 1 : 0;
  }
  EXPECT_EQ(turns, 4);
  // The same in the truth: between scans inside one phase, heading and place never change together.
  int mixed = 0, turning = 0;
  const double dt_s = 0.1;
  for (double t = dt_s; t < drive.duration_s(); t += dt_s) {
    const Pose step = relative(pose_at(drive, t), pose_at(drive, t - dt_s));
    const bool moved = std::hypot(step.x_m, step.y_m) > 1e-9;
    const bool turned = std::fabs(step.theta_rad) > 1e-9;
    mixed += moved && turned ? 1 : 0;
    turning += turned ? 1 : 0;
    EXPECT_LE(std::hypot(step.x_m, step.y_m), scenario.path.speed_mps * dt_s + 1e-9);
    EXPECT_LE(std::fabs(step.theta_rad), scenario.path.turn_rate_rad_s * dt_s + 1e-9);
  }
  EXPECT_LE(mixed, 4);  // a turn that begins or ends within a step: at most one per stop, as it pauses before
  EXPECT_GE(turning, 75);  // 2 x 53.13 and 2 x 90 degrees at 0.6 rad/s are 8.3 s
}

TEST(Drive, holds_its_ends_and_faces_its_first_leg) {
  WaypointPath path;
  path.points = {{1.0, 1.0, 0.0}, {1.0, 3.0, 0.0}, {-1.0, 3.0, 2.0}};
  path.speed_mps = 1.0;
  path.turn_rate_rad_s = kDeg * 90.0;
  const Drive drive = plan_drive(path);
  EXPECT_NEAR(drive.duration_s(), 2.0 + 1.0 + 2.0 + 2.0, 1e-12);
  EXPECT_NEAR(pose_at(drive, -5.0).theta_rad, 90.0 * kDeg, 1e-12);
  EXPECT_NEAR(pose_at(drive, 2.5).theta_rad, 135.0 * kDeg, 1e-12);
  EXPECT_NEAR(pose_at(drive, 4.0).x_m, 0.0, 1e-12);
  EXPECT_NEAR(pose_at(drive, 99.0).x_m, -1.0, 1e-12);
}

TEST(ShippedPaths, keep_clear_of_walls) {
  for (const char* name : {"paz2012", "office", "spin", "two_lidars"}) {
    const Scenario scenario = read_scenario(kRoot + "configs/" + name + "_scenario.yaml");
    for (const std::string& map_path : {scenario.map_path, scenario.localization_map_path}) {
      const GridMap map = read_map(map_path);
      const Drive drive = plan_drive(scenario.path);
      double clearance_m = 1.0;
      for (double t = 0.0; t < drive.duration_s(); t += 0.2) {
        const Pose pose = pose_at(drive, t);
        for (int k = 0; k < 36; ++k) {
          const SimulatedHit wall = cast_simulated_ray(map, pose.x_m, pose.y_m, k * 10.0 * kDeg, 1.0);
          clearance_m = std::min(clearance_m, wall.range_m);
        }
      }
      EXPECT_GE(clearance_m, 0.3) << map_path;  // a small robot fits
    }
    const double minutes = plan_drive(scenario.path).duration_s() / 60.0;
    if (std::string(name) == "office") {
      EXPECT_NEAR(minutes, 5.0, 0.5);
    }
  }
}

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
    const Pose odometry = relative(scans[k].odometry, s.odometry.start);
    EXPECT_NEAR(truth.x_m, odometry.x_m, 1e-9);
    EXPECT_NEAR(truth.y_m, odometry.y_m, 1e-9);
    EXPECT_NEAR(truth.theta_rad, odometry.theta_rad, 1e-9);
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
  s.odometry.scale_rotation =
      1.1;  // left, right, left, right: 53.13, -53.13, 90, -90 degrees cancel; seen in between
  const SimulatedLog log = simulate(s, fine_hall());
  double largest = 0.0;
  for (const LogRecord& record : log.records) largest = std::max(largest, record.odometry.theta_rad);
  EXPECT_NEAR(largest, 1.1 * 90.0 * kDeg, 1e-9);
}

// ---- scans that take time, several LiDARs --------------------------------------------------------
/// Turns left on the spot at 1 rad/s in the corridor, from the first second to the seventh.
Scenario spin() {
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

TEST(Drive, spins_on_the_spot) {
  WaypointPath path;
  path.points = {{1.0, 1.0, 0.5, -7.0}, {3.0, 1.0, 0.0, 1.0}};
  path.speed_mps = 1.0;
  path.turn_rate_rad_s = 2.0;
  const Drive drive = plan_drive(path);
  const double back_rad = 7.0 - 2.0 * std::numbers::pi;  // the short way to the next point
  EXPECT_NEAR(drive.duration_s(), 0.5 + 3.5 + back_rad / 2.0 + 2.0 + 0.5, 1e-12);
  EXPECT_NEAR(pose_at(drive, 1.5).theta_rad, -2.0, 1e-12);
  EXPECT_NEAR(pose_at(drive, 4.0).theta_rad, -back_rad, 1e-12);
  EXPECT_NEAR(pose_at(drive, drive.duration_s()).theta_rad, 1.0, 1e-12);
  EXPECT_EQ(pose_at(drive, 3.0).x_m, 1.0);
}

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
/// The message of the Error that `body` throws, and its kind.
template <class Body>
std::string error_of(Body&& body, ErrorKind kind) {
  try {
    body();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), kind) << e.what();
    return e.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

TEST(Simulator, refuses_a_path_through_walls) {
  Scenario s = straight_10_m();
  s.path.points[1] = {2.0, 5.0, 0.0};
  EXPECT_NE(error_of([&] { simulate(s, corridor()); }, ErrorKind::input).find("point 2"), std::string::npos);
  GridMap map = corridor();
  for (int j = 0; j < map.height; ++j)
    map.cells[static_cast<std::size_t>(j * map.width + 60)] = Cell::occupied;
  s = straight_10_m();
  EXPECT_NE(error_of([&] { simulate(s, map); }, ErrorKind::input).find("wall"), std::string::npos);
}

TEST(Simulator, refuses_rates_that_do_not_fit_and_drives_without_end) {
  Scenario s = straight_10_m();
  s.scan_rate_hz = 7.0;
  EXPECT_NE(error_of([&] { simulate(s, corridor()); }, ErrorKind::config).find("5 ms"), std::string::npos);
  s.scan_rate_hz = 40.0;
  EXPECT_NE(error_of([&] { simulate(s, corridor()); }, ErrorKind::config).find("multiple"),
            std::string::npos);
  s = straight_10_m();
  s.path.speed_mps = 1e-9;
  EXPECT_NE(error_of([&] { simulate(s, corridor()); }, ErrorKind::config).find("million"), std::string::npos);
}

TEST(Simulator, refuses_times_that_do_not_fit) {
  Scenario s = straight_10_m();
  s.lidar.scan_time_s = 0.11;
  EXPECT_NE(error_of([&] { simulate(s, corridor()); }, ErrorKind::config).find("at most the 0.1 s between"),
            std::string::npos);
  s = straight_10_m();
  s.more_lidars = {s.lidar};
  s.more_lidars[0].delay_s = 0.02;
  EXPECT_NE(
      error_of([&] { simulate(s, corridor()); }, ErrorKind::config).find("multiple of the odometry's period"),
      std::string::npos);
}

TEST(ScenarioReader, names_what_is_wrong_and_where) {
  struct Case {
    const char* text;
    const char* expected;
  };
  const Case cases[] = {
      {"map: a.yaml\npath: b.yaml\nsed: 3\n", "s.yaml:3: unknown key 'sed'; the nearest valid key is 'seed'"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  beems: 3\n",
       "s.yaml:4: unknown key 'lidar.beems'; the nearest valid key is 'lidar.beams'"},
      {"path: b.yaml\n", "s.yaml:1: map is missing"},
      {"map: a.yaml\npath: b.yaml\nmap: c.yaml\n", "s.yaml:3: duplicate key 'map'"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  beams: 0\n", "s.yaml:4: lidar.beams must be 1 to 4096, got 0"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  beams: 3.5\n",
       "s.yaml:4: lidar.beams must be a whole number, got '3.5'"},
      {"map: a.yaml\npath: b.yaml\nlidar: 3\n", "s.yaml:3: lidar: expected 'key: value' lines, got '3'"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  range_max: .nan\n",
       "s.yaml:4: lidar.range_max: expected a number"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  range_min: 9\n",
       "s.yaml:4: lidar.range_min must be below range_max"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  over_range: far\n",
       "s.yaml:4: lidar.over_range must be max, inf or code, got 'far'"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  mount: [1, 2]\n",
       "s.yaml:4: lidar.mount must be a list of 3 numbers"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  upside_down: 1\n",
       "s.yaml:4: lidar.upside_down must be true or false, got '1'"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  scan_time: 2\n",
       "s.yaml:4: lidar.scan_time must be 0 to 1, got 2"},
      {"map: a.yaml\npath: b.yaml\nlidar:\n  stamp_at: end\n",
       "s.yaml:4: lidar.stamp_at must be first, middle or last, got 'end'"},
      {"map: a.yaml\npath: b.yaml\nlidars:\n  - beams: 3\n  - beems: 3\n",
       "s.yaml:5: unknown key 'lidars[1].beems'; the nearest valid key is 'lidars[1].beams'"},
      {"map: a.yaml\npath: b.yaml\nlidars: 3\n", "s.yaml:3: lidars must be a list of groups, got '3'"},
      {"map: a.yaml\npath: b.yaml\nlidars: []\n", "s.yaml:3: lidars must be a list of 1 to 9 LiDARs"},
      {"map: a.yaml\npath: b.yaml\nlidars:\n  - 3\n",
       "s.yaml:4: lidars[0]: expected 'key: value' lines, got '3'"},
      {"map: a.yaml\npath: b.yaml\nlidar: {beams: 3}\nlidars: [{beams: 3}]\n",
       "s.yaml:4: lidars and lidar: only one of the two may be there"},
      {"map: a.yaml\npath: b.yaml\nodometry:\n  alpha1: 0.1\n",
       "s.yaml:4: odometry.alpha1 needs form beside it"},
      {"map: a.yaml\npath: b.yaml\nseed: -1\n", "s.yaml:3: seed must be a whole number from 0"},
      {"map: [a\n", "not valid YAML"},
      {"", "expected 'key: value' lines, got nothing"},
      {"map: a\n---\nmap: b\n", "expected one document, found a second one"},
      {", 0], a[1,b\n", "expected one document, found a second one"},  // yaml-cpp alone never ends here
      {"map: &a [*a]\n", "s.yaml:1: anchors and aliases"},
      {"[[[[[[[[[]]]]]]]]]\n", "s.yaml:1: nested too deeply"},
  };
  for (const Case& c : cases) {
    const std::string message = error_of([&] { scenario_from_text(c.text, "s.yaml"); }, ErrorKind::config);
    EXPECT_NE(message.find(c.expected), std::string::npos) << message;
  }
}

TEST(ScenarioReader, checks_the_points_of_a_path) {
  struct Case {
    const char* text;
    const char* expected;
  };
  const Case cases[] = {
      {"points: [[0, 0]]\n", "p.yaml:1: points must be a list of at least two points"},
      {"points:\n  - [0, 0]\n  - [0, x]\n", "p.yaml:3: points: point 2: expected a number, got 'x'"},
      {"points:\n  - [0, 0]\n  - [1]\n",
       "p.yaml:3: points: point 2 must be [x, y], [x, y, pause_s] or [x, y, pause_s, spin_deg]"},
      {"points:\n  - [0, 0]\n  - [0, 0]\n", "p.yaml:3: points: point 2 is the same as the one before"},
      {"points:\n  - [0, 0]\n  - [1, 0, -1]\n", "p.yaml:3: points: point 2 must pause for 0 to 3600 s"},
      {"points:\n  - [0, 0]\n  - [1, 0, 0, 40000]\n",
       "p.yaml:3: points: point 2 must spin by at most 36000 degrees"},
      {"points:\n  - [0, 0]\n  - [1e9, 0]\n", "p.yaml:3: points: point 2 is beyond 100000 m"},
      {"speed: 0\npoints: [[0, 0], [1, 0]]\n", "p.yaml:1: speed must be 0.001 to 100, got 0"},
      {"sped: 1\npoints: [[0, 0], [1, 0]]\n",
       "p.yaml:1: unknown key 'sped'; the nearest valid key is 'speed'"},
  };
  for (const Case& c : cases) {
    const std::string message = error_of([&] { waypoints_from_text(c.text, "p.yaml"); }, ErrorKind::config);
    EXPECT_NE(message.find(c.expected), std::string::npos) << message;
  }
}

TEST(ScenarioReader, reads_what_is_written) {
  const Scenario s = scenario_from_text(
      "map: ../m.yaml\nlocalization_map: n.yaml\npath: /p.yaml\nseed: 18446744073709551615\nscan_rate: 5\n"
      "lidar:\n  beams: 7\n  angle_min_deg: -90\n  angle_step_deg: 30\n  over_range: code\n  "
      "over_range_code: 50\n"
      "  dropout_value: nan\n  mount: [0.1, 0.2, 180]\n"
      "odometry:\n  form: thrun\n  alpha1: 0.3\n  rate: 10\n  drift_deg_per_m: 1\n",
      "/a/b/s.yaml");
  EXPECT_EQ(s.map_path, "/a/m.yaml");
  EXPECT_EQ(s.localization_map_path, "/a/b/n.yaml");
  EXPECT_EQ(s.path_file, "/p.yaml");
  EXPECT_EQ(s.seed, 18446744073709551615u);
  EXPECT_EQ(s.lidar.beams, 7);
  EXPECT_DOUBLE_EQ(s.lidar.angle_min_rad, -90.0 * kDeg);
  EXPECT_DOUBLE_EQ(s.lidar.angle_step_rad, 30.0 * kDeg);
  EXPECT_EQ(s.lidar.over_range, OverRange::code);
  EXPECT_EQ(s.lidar.over_range_code_m, 50.0);
  EXPECT_EQ(s.lidar.dropout_value, DropoutValue::nan);
  EXPECT_DOUBLE_EQ(s.lidar.T_base_sensor.theta_rad, -std::numbers::pi);
  EXPECT_EQ(s.odometry.noise.form, MotionForm::thrun);
  EXPECT_EQ(s.odometry.noise.alpha1, 0.3);
  EXPECT_DOUBLE_EQ(s.odometry.drift_rad_per_m, kDeg);
}

TEST(ScenarioReader, reads_several_lidars) {
  const Scenario s = scenario_from_text(
      "map: m.yaml\npath: p.yaml\nlidars:\n  - {beams: 7, scan_time: 0.05, stamp_at: middle}\n"
      "  - beams: 9\n    upside_down: true\n    delay: 0.1\n    mount: [-0.1, 0.2, 90]\n  - {}\n",
      "s.yaml");
  EXPECT_EQ(s.lidar.beams, 7);
  EXPECT_EQ(s.lidar.scan_time_s, 0.05);
  EXPECT_EQ(s.lidar.stamp_at, StampAt::middle);
  ASSERT_EQ(s.more_lidars.size(), 2u);
  EXPECT_EQ(s.more_lidars[0].beams, 9);
  EXPECT_TRUE(s.more_lidars[0].upside_down);
  EXPECT_EQ(s.more_lidars[0].delay_s, 0.1);
  EXPECT_DOUBLE_EQ(s.more_lidars[0].T_base_sensor.theta_rad, 90.0 * kDeg);
  EXPECT_EQ(s.more_lidars[1].beams, SimulatedLidar{}.beams);
  const WaypointPath path = waypoints_from_text("points:\n  - [0, 0, 1, -720]\n  - [1, 0]\n", "p.yaml");
  EXPECT_DOUBLE_EQ(path.points[0].spin_rad, -720.0 * kDeg);
  EXPECT_EQ(path.points[1].spin_rad, 0.0);
}

}  // namespace
}  // namespace parloc
