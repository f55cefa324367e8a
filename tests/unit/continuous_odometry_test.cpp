// Odometry without jumps: what a robot can do passes as it came, to the bit; what none can is left out.
#include "common/model/continuous_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace parloc {
namespace {

/// Speeds, rates and LiDARs of robots that there are.
struct Robot {
  const char* name;
  double speed_mps, rate_hz;
};
constexpr Robot kRobots[] = {{"creeping", 0.05, 40.0},      {"indoors", 0.5, 10.0},
                             {"indoors at 1 Hz", 0.8, 1.0}, {"2.5 m apart", 0.8, 0.32},
                             {"a car at 5 Hz", 6.5, 5.0},   {"a car at 1 Hz", 7.0, 1.0}};

TEST(ContinuousOdometry, WhatARobotCanDoPassesAsItCame) {
  for (const Robot& robot : kRobots) {
    SCOPED_TRACE(robot.name);
    const MotionConfig limits;
    ContinuousOdometry continuous(limits);
    for (int k = 0; k < 50; ++k) {
      const double t = k / robot.rate_hz;
      const Pose raw{robot.speed_mps * t + 0.1, -3.7, 0.2 * std::sin(t)};
      const auto reading = continuous.take(100.0 + t, raw);
      ASSERT_TRUE(reading);
      EXPECT_FALSE(reading->jumped);
      EXPECT_EQ(reading->pose.x_m, raw.x_m);
      EXPECT_EQ(reading->pose.theta_rad, raw.theta_rad);
    }
    EXPECT_EQ(continuous.jumps(), 0u);
  }
}

TEST(ContinuousOdometry, AResetOrAGlitchIsPassedOver) {
  for (const Robot& robot : kRobots) {
    const double step_s = 1.0 / robot.rate_hz;
    // At one scan per second a robot may be anywhere within 10 m.
    const double far_m = 12.0 * std::fmax(1.0, step_s) * 2.0;
    for (const bool returns : {true, false}) {
      SCOPED_TRACE(robot.name);
      const MotionConfig limits;
      ContinuousOdometry continuous(limits);
      Pose last;
      for (int k = 0; k < 40; ++k) {
        const bool beyond = returns ? k == 20 : k >= 20;
        last = continuous.take(k * step_s, {robot.speed_mps * k * step_s + (beyond ? far_m : 0.0), 0.0, 0.0})
                   ->pose;
      }
      EXPECT_EQ(continuous.jumps(), returns ? 2u : 1u);
      const double inertia_m = robot.speed_mps * std::fmax(0.0, step_s - 1.0);  // it goes on for a second
      EXPECT_NEAR(last.x_m, robot.speed_mps * 39 * step_s, 1e-6 + (returns ? 2.0 : 1.0) * inertia_m);
    }
  }
}

/// Readings at a steady rate whose stamps are those of the moments when a logger came to write them: several
/// hundredths apart or even stepping back, and then none for most of a second.
double bursting_s(int k, double step_s) {
  constexpr int kTogether = 4;
  return (k / kTogether + 1) * kTogether * step_s + 0.01 * (k % kTogether) -
         (k % 13 == 6 ? 0.3 * step_s : 0.0);
}

TEST(ContinuousOdometry, StampsThatComeInBurstsMakeNoRobotFaster) {
  for (const Robot& robot : kRobots) {
    SCOPED_TRACE(robot.name);
    const double step_s = 1.0 / robot.rate_hz;
    const double far_m = 12.0 * std::fmax(1.0, step_s) * 2.0;
    for (const bool jumps : {false, true}) {
      const MotionConfig limits;
      ContinuousOdometry continuous(limits);
      for (int k = 0; k < 400; ++k)
        continuous.take(bursting_s(k, step_s),
                        {robot.speed_mps * step_s * k + (jumps && k >= 302 ? far_m : 0.0), 0.0,
                         0.3 * std::sin(0.2 * k * step_s)});
      EXPECT_LE(continuous.jumps(), jumps ? 5u : 4u);  // in the first burst, before the pace is known
      EXPECT_GE(continuous.jumps(), jumps ? 1u : 0u);
    }
  }
}

TEST(ContinuousOdometry, NoReadingOfAnySizeLeavesItUnsound) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double odd : {1e3, -1e6, 1e15, 1e150, 1e300, -1e308, nan, inf, -inf}) {
    const MotionConfig limits;
    ContinuousOdometry continuous(limits);
    for (int k = 0; k < 30; ++k) {
      const bool is_odd = k == 7 || k == 8 || k == 20;
      const auto reading = continuous.take(0.1 * k, {is_odd ? odd : 0.05 * k, k == 8 ? -odd : 0.0, 0.0});
      EXPECT_EQ(reading.has_value(), !is_odd || std::isfinite(odd));
      if (!reading) continue;
      EXPECT_NEAR(reading->pose.x_m, 0.05 * k, 0.11) << odd << " at " << k;
      EXPECT_NEAR(reading->pose.y_m, 0.0, 1e-9);
    }
    EXPECT_EQ(continuous.invalid(), std::isfinite(odd) ? 0u : 3u);
  }
}

TEST(ContinuousOdometry, StampsThatStandStillAreGuessed) {
  const MotionConfig limits;
  ContinuousOdometry continuous(limits);
  double elapsed_s = 0.0;
  for (int k = 0; k < 100; ++k) elapsed_s += continuous.take(0.0, {0.05 * k, 0.0, 0.0})->elapsed_s;
  EXPECT_EQ(continuous.stalled(), 99u);
  EXPECT_EQ(continuous.jumps(), 0u);
  EXPECT_NEAR(elapsed_s, 10.0, 0.5);                           // a tenth of a second each
  EXPECT_TRUE(continuous.take(0.0, {8.0, 0.0, 0.0})->jumped);  // 3 m, beyond max_jump_m
  // Two LiDARs with one stamp are no clock that stands still.
  continuous.clear();
  elapsed_s = 0.0;
  for (int k = 0; k < 100; ++k) elapsed_s += continuous.take(0.1 * (k / 2), {0.025 * k, 0.0, 0.0})->elapsed_s;
  EXPECT_NEAR(elapsed_s, 4.9, 1e-9);
}

TEST(ContinuousOdometry, StampsOfAnySizeLeaveItSound) {
  const MotionConfig limits;
  ContinuousOdometry continuous(limits);
  int k = 0;
  for (const double stamp_s : {0.0, 1e300, -1e300, std::nan(""), 5.0, 4.0, 1e9, 1e9 + 0.1}) {
    const auto reading = continuous.take(stamp_s, {0.1 * k++, 0.0, 0.0});
    EXPECT_TRUE(std::isfinite(reading->pose.x_m));
    EXPECT_GE(reading->elapsed_s, 0.0);
    EXPECT_LE(reading->elapsed_s, 10.0);
  }
}

}  // namespace
}  // namespace parloc
