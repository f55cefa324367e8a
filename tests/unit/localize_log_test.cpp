// What `parloc run` does besides reading its command line: the start, the loop over scans, snapshots, step
// times.
#include "tools/localize_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "common/error.h"
#include "tests/unit/small_drive.h"
#include "tools/run_results.h"
#include "tools/start_pose.h"

namespace parloc::tools {
namespace {

void expect_error(ErrorKind kind, const std::string& part, const std::function<void()>& action) {
  try {
    action();
    ADD_FAILURE() << "no error; expected: " << part;
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), kind) << e.what();
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  }
}

LocalizeRequest small_request() {
  LocalizeRequest request;
  request.config.particles = 200;
  request.config.threads = 1;
  request.config.backend = BackendChoice::cpu;
  request.start = StartPose{false, {1.0, 1.0, 0.0}, 0.05, 0.05, 0.05};
  request.log_name = "drive.log";
  return request;
}

Localization localize(const std::string& log, const LocalizeRequest& request) {
  return localize_log(test::small_room(), *carmen_log_from_text(log, "drive.log"), request);
}

TEST(StartPose, IsParsedStrictly) {
  FilterConfig config;
  config.initial_sigma_xy = 0.3;
  config.initial_sigma_theta = 0.2;
  const StartPose three = parse_start_pose("1.5,-2,+0.5", config);
  EXPECT_FALSE(three.anywhere);
  EXPECT_EQ(three.pose.x_m, 1.5);
  EXPECT_EQ(three.pose.y_m, -2.0);
  EXPECT_EQ(three.pose.theta_rad, 0.5);
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
  const FilterConfig config;
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
    EXPECT_LT(std::hypot(run.trajectory[k].pose.x_m - drive.truth[k].pose.x_m,
                         run.trajectory[k].pose.y_m - drive.truth[k].pose.y_m),
              0.2);
    // Exact odometry from the true start is the truth; the log has 9 decimals.
    EXPECT_NEAR(run.odometry[k].pose.x_m, drive.truth[k].pose.x_m, 1e-8);
    EXPECT_NEAR(run.odometry[k].pose.theta_rad, drive.truth[k].pose.theta_rad, 1e-8);
  }
}

TEST(LocalizeLog, AnywhereHasNoDeadReckoning) {
  LocalizeRequest request = small_request();
  request.start = StartPose{true, {}, 0, 0, 0};
  const Localization run = localize(test::carmen_log_of(test::small_drive(test::small_room(), 5)), request);
  EXPECT_TRUE(run.odometry.empty());
  EXPECT_EQ(run.trajectory.size(), 5u);
}

double spread_m(const StepRecord& step) {
  return std::hypot(step.sigma_x_m, step.sigma_y_m);
}

TEST(LocalizeLog, OdometryOnlySpreadsTheParticlesAndWeighsNothing) {
  const test::SmallDrive drive = test::small_drive(test::small_room(), 40);
  LocalizeRequest request = small_request();
  request.config.particles = 2000;
  const double with_scans_m = spread_m(localize(test::carmen_log_of(drive), request).steps.back());
  request.odometry_only = true;
  const Localization run = localize(test::carmen_log_of(drive), request);

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
  EXPECT_GT(spread_m(run.steps.back()), 5.0 * with_scans_m);
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    // The mean of 2000 is within 5 / sqrt(2000) = 0.11 sigma; the cloud's bend shortens it by a little more.
    EXPECT_LT(std::hypot(run.trajectory[k].pose.x_m - run.odometry[k].pose.x_m,
                         run.trajectory[k].pose.y_m - run.odometry[k].pose.y_m),
              0.2 * spread_m(run.steps[k]))
        << k;
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
  const std::string log = test::carmen_log_of(test::small_drive(test::small_room(), 20));
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
  const std::string log = test::carmen_log_of(test::small_drive(test::small_room(), 3));
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

TEST(StepTimes, LeaveOutTheFirstStep) {
  const auto times_of = [](const std::vector<double>& ms) {
    std::vector<StepRecord> steps;
    for (const double v : ms) {
      StepRecord step;
      step.step_ms = v;
      steps.push_back(step);
    }
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
