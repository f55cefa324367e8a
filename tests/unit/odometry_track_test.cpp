// The robot's motion around a scan: arcs between odometry readings, and what is done where there are none.
#include "common/model/odometry_track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/expect.h"

namespace parloc {
namespace {

/// Where a body with this twist is after a time, by steps so short that their form does not matter.
Pose integrated(double forward_mps, double left_mps, double turn_rad_s, double time_s) {
  constexpr int steps = 200'000;
  double x = 0, y = 0, a = 0;
  const double dt = time_s / steps;
  for (int k = 0; k < steps; ++k) {
    const double mid = a + 0.5 * turn_rad_s * dt;
    x += dt * (forward_mps * std::cos(mid) - left_mps * std::sin(mid));
    y += dt * (forward_mps * std::sin(mid) + left_mps * std::cos(mid));
    a += turn_rad_s * dt;
  }
  return {x, y, a};
}

void expect_near(const Pose& a, const Pose& b, double tolerance) {
  EXPECT_NEAR(a.x_m, b.x_m, tolerance);
  EXPECT_NEAR(a.y_m, b.y_m, tolerance);
  EXPECT_NEAR(std::remainder(a.theta_rad - b.theta_rad, 2 * M_PI), 0.0, tolerance);
}

TEST(AlongArc, IsTheMotionOfAConstantTwist) {
  // Around the limit of the series (0.01), far above it, and to nearly half a turn.
  for (const double turn : {0.0, 1e-9, 0.0099, 0.0101, -0.3, 1.0, -3.1}) {
    const Pose step = integrated(0.7, -0.2, turn, 1.0);
    for (const double part : {-1.5, -0.1, 0.25, 0.9, 1.0, 2.0}) {
      // The midpoint rule errs by turn^2 / 24 / steps^2: below 1e-11.
      expect_near(along_arc(step, part), integrated(0.7, -0.2, turn, part), 1e-10);
    }
    expect_equal(along_arc(step, 0.0), {});
  }
  expect_equal(along_arc({}, 0.37), {});
}

/// On a circle: 0.5 m/s and 1 rad/s, the odometry frame's origin elsewhere.
Pose on_circle(double t) {
  const Pose moved{0.5 * std::sin(t), 0.5 * (1 - std::cos(t)), std::remainder(t, 2 * M_PI)};
  return compose({3.0, -2.0, 1.0}, moved);
}
Pose circle_motion(double from, double to) {
  return relative(on_circle(to), on_circle(from));
}

TEST(OdometryTrack, FollowsAnArcBetweenAndBeyondTheReadings) {
  OdometryTrack track(MotionConfig{});
  for (const double t : {10.0, 10.05, 10.1, 10.15}) track.add(t, on_circle(t));
  ASSERT_TRUE(track.knows_motion());
  for (const double t : {9.9, 9.99, 10.0, 10.01, 10.05, 10.12, 10.15, 10.2, 10.25})
    expect_near(track.motion(10.05, t), circle_motion(10.05, t), 1e-9);  // stamps near 10 s have 2e-15
  expect_equal(track.motion(10.03, 10.03), {});
}

TEST(OdometryTrack, GoesOnWithTheLastTwist) {
  OdometryTrack track(MotionConfig{});
  track.add(0.0, {0, 0, 0});
  track.add(0.1, {0.1, 0, 0});
  track.add(0.2, {0.1, 0, 0.2});  // stopped, now turns at 2 rad/s
  expect_near(track.motion(0.2, 0.25), {0, 0, 0.1}, 1e-12);
  expect_near(track.motion(0.0, -0.05), {-0.05, 0, 0}, 1e-12);
}

TEST(OdometryTrack, TakesATwistOverMoreThanAJitter) {
  OdometryTrack track(MotionConfig{});
  track.add(0.0, {0, 0, 0});
  track.add(0.1, {0.1, 0, 0});
  track.add(0.1001, {0.11, 0, 0});  // 100 m/s by these two alone
  EXPECT_NEAR(track.motion(0.1001, 0.2001).x_m, 0.11 / 0.1001 * 0.1, 1e-12);
}

// 0.5 m/s, read every 0.2 s; but of every two readings the first is stamped as late as the second.
TEST(OdometryTrack, TakesATwistOverAsLongAsItIsToldTo) {
  OdometryTrack track(MotionConfig{});
  double last_s = 0.0;
  for (int k = 0; k < 8; ++k) {
    last_s = 0.4 * (k / 2) + (k % 2 == 0 ? 0.199 : 0.2);
    track.add(last_s, {0.1 * k, 0.0, 0.0});
  }
  EXPECT_NEAR(track.motion(last_s, last_s + 0.3, 0.3).x_m, 0.15, 0.08);
  EXPECT_NEAR(track.motion(last_s, last_s + 0.3, 0.8).x_m, 0.15, 0.001);
}

TEST(OdometryTrack, KnowsNoMotionWithoutTwoReadings) {
  OdometryTrack track(MotionConfig{});
  EXPECT_FALSE(track.knows_motion());
  expect_equal(track.motion(0.0, 1.0), {});
  track.add(5.0, {1, 2, 3});
  EXPECT_FALSE(track.knows_motion());
  expect_equal(track.motion(5.0, 5.1), {});
  track.add(5.01, {1.1, 2, 3});
  EXPECT_FALSE(track.knows_motion());  // nearer than the shortest twist
  track.add(5.025, {1.2, 2, 3});
  EXPECT_TRUE(track.knows_motion());
}

TEST(OdometryTrack, SortsReadingsAndKeepsTheLastOfEqualStamps) {
  OdometryTrack in_order(MotionConfig{}), mixed(MotionConfig{});
  const std::vector<double> stamps{1.0, 1.1, 1.2, 1.3};
  for (const double t : stamps) in_order.add(t, on_circle(t));
  mixed.add(1.1, {9, 9, 9});
  mixed.clear();
  for (const double t : {1.2, 1.0, 1.3}) mixed.add(t, on_circle(t));
  mixed.add(1.1, on_circle(1.7));
  mixed.add(1.1, on_circle(1.1));
  for (const double t : {0.9, 1.05, 1.15, 1.4}) expect_equal(mixed.motion(1.2, t), in_order.motion(1.2, t));
}

TEST(OdometryTrack, ForgetsWhatIsOldOrOfAnotherClockOrBeforeAJump) {
  OdometryTrack track(MotionConfig{});
  track.add(0.0, {0, 0, 0});
  track.add(3.0, {0.5, 0, 0});
  EXPECT_FALSE(track.knows_motion());  // 3 s: too long ago to say anything
  track.add(3.1, {0.6, 0, 0});
  EXPECT_TRUE(track.knows_motion());
  track.add(0.5, {0.1, 0, 0});  // the log starts anew
  EXPECT_FALSE(track.knows_motion());
  track.add(0.6, {0.2, 0, 0});
  EXPECT_TRUE(track.knows_motion());
  track.add(0.7, {5.2, 0, 0});
  EXPECT_FALSE(track.knows_motion());
  track.add(0.8, {5.3, 0, 0});
  EXPECT_NEAR(track.motion(0.8, 0.9).x_m, 0.1, 1e-12);
}

TEST(OdometryTrack, IgnoresWhatIsNotFinite) {
  OdometryTrack track(MotionConfig{});
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  track.add(1.0, {0, 0, 0});
  track.add(1.1, {0.1, 0, 0});
  track.add(nan, {0, 0, 0});
  track.add(inf, {0, 0, 0});
  track.add(1.05, {nan, 0, 0});
  track.add(1.05, {0, 0, inf});
  EXPECT_NEAR(track.motion(1.0, 1.05).x_m, 0.05, 1e-15);
}

TEST(OdometryTrack, StandingStillIsExactlyNoMotion) {
  OdometryTrack track(MotionConfig{});
  const Pose anywhere{12.3456, -7.89, 2.71828};
  for (const double t : {100.0, 100.05, 100.1}) track.add(t, anywhere);
  for (const double t : {99.9, 100.01, 100.05, 100.2}) expect_equal(track.motion(100.03, t), {});
}

}  // namespace
}  // namespace parloc
