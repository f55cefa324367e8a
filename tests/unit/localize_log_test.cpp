// What `parloc run` does besides reading its command line: the start, the loop over scans, snapshots, step
// times.
#include "tools/run/localize_log.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/config/config.h"
#include "common/eval/metrics.h"
#include "common/simulator/simulator.h"
#include "tests/unit/expect.h"
#include "tests/unit/small_drive.h"
#include "tools/run/run_results.h"
#include "tools/run/start_pose.h"

namespace parloc::tools {
namespace {

void expect_error(ErrorKind kind, const std::string& part, const std::function<void()>& action) {
  expect_parts(error_of(action, kind), {part});
}

LocalizeRequest small_request(const Pose& start = {1.0, 1.0, 0.0}) {
  LocalizeRequest request;
  request.config.particles = 200;
  request.config.threads = 1;
  request.config.backend = BackendChoice::cpu;
  request.start = StartPose{false, start, 0.05, 0.05, 0.05};
  request.log_name = "drive.log";
  return request;
}

Localization localize(const std::string& log, const LocalizeRequest& request) {
  return localize_log(test::small_room(), *carmen_log_from_text(log, "drive.log"), request);
}
std::string log_of_scans(int count) {
  return carmen_log_of(test::small_drive(test::small_room(), count));
}

TEST(StartPose, IsParsedStrictly) {
  Config config;
  config.initial_sigma_xy = 0.3;
  config.initial_sigma_theta = 0.2;
  const StartPose three = parse_start_pose("1.5,-2,+0.5", config);
  EXPECT_FALSE(three.anywhere);
  expect_equal(three.pose, {1.5, -2.0, 0.5});
  EXPECT_EQ(three.sigma_y_m, 0.3);
  EXPECT_EQ(three.sigma_theta_rad, 0.2);
  const StartPose six = parse_start_pose("1,2,3.5,0,0.25,1e-3", config);
  EXPECT_NEAR(six.pose.theta_rad, 3.5 - 2.0 * M_PI, 1e-15);  // wrapped; one rounding
  EXPECT_EQ(six.sigma_x_m, 0.0);
  EXPECT_EQ(six.sigma_y_m, 0.25);
  EXPECT_EQ(six.sigma_theta_rad, 1e-3);
  EXPECT_TRUE(parse_start_pose("global", config).anywhere);
  for (const char* bad : {"", ",", "1,2", "1,2,3,4", "1,2,3,4,5,6,7", "1,2,x", "1,2,", "1,2,3 ", "nan,0,0",
                          "0,inf,0", "1e999,0,0", "1,2,90", "1,2,3,-1,0,0", "Global", "1;2;3"}) {
    expect_error(ErrorKind::usage, "--init", [&] { parse_start_pose(bad, config); });
  }
}

TEST(StartPose, FromTruthIsTheNearestRowInTime) {
  const Trajectory truth{{10.0, {1, 0, 0}}, {9.0, {2, 0, 0}}, {12.0, {3, 0, 0}}, {12.0, {4, 0, 0}}};
  const Config config;
  EXPECT_EQ(start_from_truth(truth, 9.4, config).pose.x_m, 2.0);
  EXPECT_EQ(start_from_truth(truth, 10.6, config).pose.x_m, 1.0);
  EXPECT_EQ(start_from_truth(truth, 12.5, config).pose.x_m, 3.0);  // the first of equals
  EXPECT_EQ(start_from_truth(truth, 12.5, config).sigma_x_m, config.initial_sigma_xy);
  expect_error(ErrorKind::input, "--init", [&] { start_from_truth(truth, 13.6, config); });
  expect_error(ErrorKind::input, "--init", [&] { start_from_truth({}, 0.0, config); });
  expect_error(ErrorKind::input, "--init", [&] { start_from_truth(truth, std::nan(""), config); });
}

TEST(LocalizeLog, OneRowPerScanAtTheScan) {
  const test::SmallDrive drive = test::small_drive(test::small_room(), 30);
  const Localization run = localize(test::carmen_log_of(drive), small_request());
  ASSERT_EQ(run.trajectory.size(), 30u);
  ASSERT_EQ(run.odometry.size(), 30u);
  EXPECT_EQ(run.steps.size(), 30u);
  EXPECT_EQ(run.scans, 30u);
  EXPECT_EQ(run.filter_steps, 30u);
  EXPECT_FALSE(run.interrupted);
  EXPECT_NEAR(run.log_s, 2.9, 1e-9);
  EXPECT_EQ(run.digest.size(), 64u);
  for (std::size_t k = 0; k < 30; ++k) {
    EXPECT_DOUBLE_EQ(run.trajectory[k].stamp_s, drive.truth[k].stamp_s);
    // Two cells: 200 particles on a map of 10 cm.
    EXPECT_LT(distance_m(run.trajectory[k].pose, drive.truth[k].pose), 0.2);
    // Exact odometry from the true start is the truth; the log has 9 decimals.
    expect_near(run.odometry[k].pose, drive.truth[k].pose, 1e-8, 1e-8);
  }
}

TEST(LocalizeLog, EveryScanIsAnsweredAsItIsWrittenAndWithTheBeamsThatWereUsed) {
  test::SmallDrive drive = test::small_drive(test::small_room(), 6);
  drive.scans[3].scan.ranges_m.assign(61, 0.0f);  // nothing that could be used
  LocalizeRequest request = small_request();
  std::vector<std::size_t> beams;
  Trajectory answered;
  request.answered = [&](const ScanAnswer& answer) {
    beams.push_back(answer.beams_used);
    answered.push_back({answer.stamp_s, answer.estimate.filter.pose});
    EXPECT_TRUE(answer.judged);
    EXPECT_EQ(answer.estimate.filter.weighted, answer.beams_used > 0);
  };
  const Localization run = localize(test::carmen_log_of(drive), request);
  EXPECT_EQ(beams, (std::vector<std::size_t>{61, 61, 61, 0, 61, 61}));
  ASSERT_EQ(answered.size(), run.trajectory.size());
  for (std::size_t k = 0; k < answered.size(); ++k) {
    EXPECT_EQ(answered[k].stamp_s, run.trajectory[k].stamp_s);
    EXPECT_EQ(answered[k].pose.x_m, run.trajectory[k].pose.x_m);
    EXPECT_EQ(answered[k].pose.theta_rad, run.trajectory[k].pose.theta_rad);
  }
}

TEST(LocalizeLog, StampsThatStandStillAreOneWarningAndStrictRefusesThem) {
  test::SmallDrive drive = test::small_drive(test::small_room(), 20);
  for (LogRecord& record : drive.scans) record.stamp_s = record.scan.stamp_s = 0.0;
  const std::string log = test::carmen_log_of(drive);
  const std::string words = "stamps stand still: 19 of 20 scans";
  RunResults results;
  results.run = localize(log, small_request());
  const std::string summary = run_summary(results);
  EXPECT_NE(summary.find(words), std::string::npos) << summary;
  EXPECT_EQ(summary.find("stamps"), summary.rfind("stamps")) << summary;
  EXPECT_NE(metrics_json(results).find(words), std::string::npos);
  LocalizeRequest strict = small_request();
  strict.strict = true;
  expect_error(ErrorKind::input, words, [&] { localize(log, strict); });
}

TEST(LocalizeLog, AnywhereHasNoDeadReckoning) {
  LocalizeRequest request = small_request();
  request.start = StartPose{true, {}, 0, 0, 0};
  const Localization run = localize(log_of_scans(5), request);
  EXPECT_TRUE(run.odometry.empty());
  EXPECT_EQ(run.trajectory.size(), 5u);
}

double spread_m(const StepRecord& step) {
  return std::hypot(step.sigma_x_m, step.sigma_y_m);
}

TEST(LocalizeLog, OdometryOnlySpreadsTheParticlesAndWeighsNothing) {
  const std::string log = log_of_scans(40);
  LocalizeRequest request = small_request();
  request.config.particles = 2000;
  const double with_scans_m = spread_m(localize(log, request).steps.back());
  request.odometry_only = true;
  const Localization run = localize(log, request);

  EXPECT_EQ(run.beams.used, 0u);
  EXPECT_EQ(run.lost_steps, 0u);
  for (const StepRecord& step : run.steps) {
    EXPECT_FALSE(step.resampled);
    EXPECT_DOUBLE_EQ(step.n_eff, 2000.0);  // equal weights
  }
  for (std::size_t k = 8; k < run.steps.size(); k += 8) {
    EXPECT_GT(spread_m(run.steps[k]), spread_m(run.steps[k - 8])) << k;
    EXPECT_GT(run.steps[k].sigma_theta_rad, run.steps[k - 8].sigma_theta_rad) << k;
  }
  // With scans it is what the cells of the map leave open, half of 0.1 m, and little else.
  EXPECT_LT(with_scans_m, 0.06);
  EXPECT_GT(spread_m(run.steps.back()), 3.0 * with_scans_m);
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    // The mean of 2000 is within 5 / sqrt(2000) = 0.11 sigma; the cloud's bend shortens it by a little more.
    EXPECT_LT(distance_m(run.trajectory[k].pose, run.odometry[k].pose), 0.2 * spread_m(run.steps[k])) << k;
  }
  for (const Snapshot& snapshot : run.snapshots) EXPECT_TRUE(snapshot.scan_points.empty());
}

TEST(LocalizeLog, OdometryOnlyDoesNotLookAtTheScans) {
  test::SmallDrive drive = test::small_drive(test::small_room(), 10);
  LocalizeRequest request = small_request();
  request.odometry_only = true;
  const std::string digest = localize(test::carmen_log_of(drive), request).digest;
  for (LogRecord& record : drive.scans) record.scan.ranges_m.assign(61, 1.0F);
  EXPECT_EQ(localize(test::carmen_log_of(drive), request).digest, digest);
  request.odometry_only = false;
  EXPECT_NE(localize(test::carmen_log_of(drive), request).digest, digest);
}

TEST(LocalizeLog, SnapshotsAreFewEvenAndEndWithTheLastScan) {
  for (const int count : {1, 5, 12, 13, 40}) {
    const test::SmallDrive drive = test::small_drive(test::small_room(), count);
    const Localization run = localize(test::carmen_log_of(drive), small_request());
    const std::size_t n = run.snapshots.size();
    EXPECT_EQ(n, count <= 12 ? static_cast<std::size_t>(count) : count == 13 ? 7u : 11u) << count;
    EXPECT_DOUBLE_EQ(run.snapshots.front().stamp_s, drive.truth.front().stamp_s);
    EXPECT_DOUBLE_EQ(run.snapshots.back().stamp_s, drive.truth.back().stamp_s);
    for (std::size_t k = 1; k < n; ++k) EXPECT_GT(run.snapshots[k].stamp_s, run.snapshots[k - 1].stamp_s);
    EXPECT_EQ(run.snapshots.back().particles.size(), 200u);
    EXPECT_EQ(run.snapshots.back().scan_points.size(), 61u);
  }
}

TEST(LocalizeLog, StopsWhenAsked) {
  LocalizeRequest request = small_request();
  std::size_t done = 0;
  request.progress = [&](double fraction, std::size_t scans) {
    EXPECT_GE(fraction, 0.0);
    EXPECT_LE(fraction, 1.0);
    done = scans;
  };
  const std::string log = log_of_scans(20);
  request.stop = [&] { return done == 7; };
  const Localization run = localize(log, request);
  EXPECT_TRUE(run.interrupted);
  EXPECT_EQ(run.trajectory.size(), 7u);
  EXPECT_DOUBLE_EQ(run.snapshots.back().stamp_s, run.trajectory.back().stamp_s);
  request.stop = [] { return true; };
  const Localization none = localize(log, request);
  EXPECT_TRUE(none.interrupted);
  EXPECT_EQ(none.scans, 0u);
  request.stop = [&] { return done == 20; };  // too late to be an interruption
  EXPECT_FALSE(localize(log, request).interrupted);
}

TEST(LocalizeLog, RefusesWhatItCannotStartWith) {
  const std::string log = log_of_scans(3);
  LocalizeRequest request = small_request();
  expect_error(ErrorKind::input, "drive.log: expected at least one scan",
               [&] { localize("ODOM 0 0 0 0 0 0 1 a 1\n", request); });
  expect_error(ErrorKind::input, "drive.log: expected at least one scan", [&] { localize("", request); });
  request.start->pose.x_m = 100.0;
  expect_error(ErrorKind::input, "", [&] { localize(log, request); });
  request.start->pose.x_m = std::numeric_limits<double>::quiet_NaN();
  expect_error(ErrorKind::input, "", [&] { localize(log, request); });
  request.start.reset();
  expect_error(ErrorKind::usage, "--init", [&] { localize(log, request); });
}

// ---- several LiDARs, and scans that take time -----------------------------------------------------

/// A robot that turns on the spot at 1 rad/s in the small room, two turns left and two right, and scans ten
/// times a second.
Scenario spin(double scan_time_s, StampAt stamp_at) {
  Scenario s;
  s.path.name = "spin";
  s.path.points = {{1.5, 2.0, 0.5, 4.0 * M_PI}, {2.0, 2.0, 0.5, -4.0 * M_PI}};
  s.path.turn_rate_rad_s = 1.0;
  s.lidar.beams = 180;
  s.lidar.angle_min_rad = -M_PI;
  s.lidar.angle_step_rad = M_PI / 90.0;
  s.lidar.T_base_sensor = {0.2, 0.0, 0.0};
  s.lidar.sigma_range_m = 0.01;
  s.lidar.scan_time_s = scan_time_s;
  s.lidar.stamp_at = stamp_at;
  return s;
}

struct SpinErrors {
  double heading_rad, position_m;  // RMSE
};
/// `told_s` is the scan time that the filter is told.
SpinErrors localize_spin(double true_s, double told_s, StampAt stamp_at) {
  const GridMap room = test::small_room();
  const SimulatedLog log = simulate(spin(true_s, stamp_at), room);
  LocalizeRequest request = small_request({1.5, 2.0, 0.0});
  request.config.particles = 1000;
  request.config.lidars = {{.name = "robotlaser1", .scan_time = told_s, .stamp_at = stamp_at}};
  const Localization run = localize_log(room, *carmen_log_from_text(carmen_text(log), "spin.log"), request);
  const TrackErrors errors = compare_tracks(run.trajectory, log.truth);
  EXPECT_EQ(run.lidars.size(), 1u);
  EXPECT_EQ(run.lidars[0].moving, told_s > 0.0 ? run.scans : 0u);
  // It reads ahead to the last beam, so that even the first scan's motion is known; one stamped at its last
  // beam lies before all odometry.
  EXPECT_EQ(run.lidars[0].unknown_motion, told_s > 0.0 && stamp_at == StampAt::last ? 1u : 0u);
  return {errors.heading_rmse_rad, errors.position_rmse_m};
}

// docs/results/deskew.md has the same on a larger scale.
TEST(Deskewing, RemovesMostOfTheErrorOfTurningAtOneRadianPerSecond) {
  for (const StampAt at : {StampAt::first, StampAt::last}) {
    const SpinErrors instant = localize_spin(0.0, 0.0, at);
    const SpinErrors ignored = localize_spin(0.1, 0.0, at);
    const SpinErrors deskewed = localize_spin(0.1, 0.1, at);
    // Half a scan's turn, 0.05 rad, is what ignoring it costs.
    EXPECT_GT(ignored.heading_rad - instant.heading_rad, 0.03);
    EXPECT_LT(deskewed.heading_rad - instant.heading_rad, 0.2 * (ignored.heading_rad - instant.heading_rad));
    EXPECT_LT(deskewed.position_m - instant.position_m, 0.2 * (ignored.position_m - instant.position_m));
  }
}

std::string two_lidar_log() {
  Scenario s = spin(0.0, StampAt::first);
  s.more_lidars = {s.lidar};
  s.more_lidars[0].beams = 60;
  s.more_lidars[0].delay_s = 0.05;
  s.lidar.dropout_probability = 0.1;
  return carmen_text(simulate(s, test::small_room()));
}

TEST(LocalizeLog, SummaryTellsHowManyBeamsOfEachLidarWereUsedAndWhy) {
  LocalizeRequest request = small_request({1.5, 2.0, 0.0});
  request.config.lidars = {{.name = "robotlaser1", .max_beams = 70, .scan_time = 0.05}};
  RunResults results;
  results.run = localize(two_lidar_log(), request);
  ASSERT_EQ(results.run.lidars.size(), 2u);
  EXPECT_EQ(results.run.scans, results.run.lidars[0].scans + results.run.lidars[1].scans);
  EXPECT_EQ(results.run.trajectory.size(), results.run.scans);  // a step and a row for each
  expect_parts(run_summary(results),
               {"robotlaser1: 70 of 180 per scan (evenly in angle, every 2.6th; max_beams 70); ",
                " % dropped: ", " zero\n", "robotlaser1: 272 of 272 scans\n",
                "robotlaser2: 60 of 60 per scan (all; max_beams 100)\n"});
  expect_parts(metrics_json(results),
               {"\"name\": \"robotlaser2\"", "\"scans_deskewed\": 272", "\"scan_time\": 0.05"});
}

TEST(LocalizeLog, SaysSoWhenAConfiguredLidarIsNotInTheLog) {
  LocalizeRequest request = small_request({1.5, 2.0, 0.0});
  request.config.lidars = {{.name = "robotlaser1"}, {.name = "front"}, {.name = "rear"}};
  RunResults results;
  const std::string log = two_lidar_log();
  results.run = localize(log, request);
  const std::string expected =
      "lidars.front, lidars.rear in the configuration, but the log has scans of robotlaser1, robotlaser2 "
      "only";
  expect_parts(run_summary(results), {expected});
  request.strict = true;
  request.config.scan.zero_policy = ZeroPolicy::miss;  // the log's zeros are no trouble then
  expect_error(ErrorKind::input, "drive.log: " + expected, [&] { localize(log, request); });
  request.config.lidars.clear();
  EXPECT_EQ(localize(log, request).scans, results.run.scans);
}

TEST(StepTimes, LeaveOutTheFirstStep) {
  const auto times_of = [](const std::vector<double>& ms) {
    std::vector<StepRecord> steps(ms.size());
    for (std::size_t k = 0; k < ms.size(); ++k) steps[k].step_ms = ms[k];
    return step_times(steps);
  };
  EXPECT_TRUE(std::isnan(times_of({}).median_ms));
  EXPECT_TRUE(std::isnan(times_of({5}).p99_ms));
  EXPECT_EQ(times_of({99, 3}).median_ms, 3.0);
  EXPECT_EQ(times_of({99, 3}).p99_ms, 3.0);
  EXPECT_EQ(times_of({99, 3, 1, 2, 4}).median_ms, 2.5);
  std::vector<double> hundred{1e9};
  for (int k = 100; k >= 1; --k) hundred.push_back(k);
  EXPECT_EQ(times_of(hundred).median_ms, 50.5);
  EXPECT_EQ(times_of(hundred).p99_ms, 99.0);
}

}  // namespace
}  // namespace parloc::tools
