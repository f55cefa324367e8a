// A delay of the odometry that was put into a drive is found again.
#include "tools/learn/odometry_delay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "common/math/pose.h"

namespace parloc::tools {
namespace {

/// A way that turns here and there, as rooms make it.
Pose way(double t_s) {
  return {0.5 * t_s, std::sin(0.4 * t_s), 0.9 * std::sin(0.7 * t_s) + 0.4 * std::sin(1.9 * t_s)};
}

/// Even numbers from -1 to 1, the same on every machine.
class Noise {
 public:
  double next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) * 0x1p-52 - 1.0;
  }

 private:
  std::uint64_t state_ = 1;
};

struct Drive {
  Trajectory odometry, poses;
};

/// 60 s at `rate_hz`; odometry of a frame and of a scale of its own.
Drive drive(double rate_hz, double delay_s, double noise_rad = 0.0, double scale = 1.0) {
  Drive d;
  Noise noise;
  const Pose T_odometry_map{4.0, -2.0, 1.0};
  for (int k = 0; k < 60.0 * rate_hz; ++k) {
    const double t_s = 1.7e9 + k / rate_hz;
    Pose true_pose = way(k / rate_hz), late = way(k / rate_hz - delay_s);
    true_pose.theta_rad += noise_rad * noise.next();
    late.theta_rad = scale * late.theta_rad + noise_rad * noise.next();
    d.poses.push_back({t_s, true_pose});
    d.odometry.push_back({t_s, compose(T_odometry_map, late)});
  }
  return d;
}

TEST(OdometryDelay, ComesBackAtEveryRateWithinItsStandardError) {
  for (const double rate_hz : {4.0, 10.0, 30.0}) {
    for (const double delay_s : {-0.2, 0.0, 0.05}) {
      const Drive d = drive(rate_hz, delay_s, 0.003, 1.03);
      const auto found = estimate_odometry_delay(d.odometry, d.poses);
      ASSERT_TRUE(found.has_value()) << rate_hz << " Hz, " << delay_s << " s";
      EXPECT_NEAR(found->delay_s, delay_s, 0.002 + 4.0 * found->sigma_s) << rate_hz << " Hz";
      EXPECT_NEAR(found->delay_s, delay_s, 0.01) << rate_hz << " Hz";
      EXPECT_LT(found->sigma_s, 0.015) << rate_hz << " Hz";
      EXPECT_EQ(found->significant(), std::fabs(delay_s) > 0.04) << rate_hz << " Hz: " << found->delay_s;
    }
  }
}

TEST(OdometryDelay, SlipsAndResetsDoNotMoveIt) {
  Drive d = drive(10.0, 0.1, 0.001);
  for (std::size_t k = 100; k < d.odometry.size(); k += 100)
    for (std::size_t after = k; after < d.odometry.size(); ++after)
      d.odometry[after].pose = compose({0.0, 0.0, 0.2}, d.odometry[after].pose);
  const auto found = estimate_odometry_delay(d.odometry, d.poses);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->delay_s, 0.1, 0.01);
  EXPECT_TRUE(found->significant());
}

TEST(OdometryDelay, WhereNothingTurnsNothingIsKnown) {
  Drive straight = drive(10.0, 0.1);
  for (Trajectory* t : {&straight.odometry, &straight.poses})
    for (StampedPose& row : *t) row.pose.theta_rad = 0.3;
  EXPECT_FALSE(estimate_odometry_delay(straight.odometry, straight.poses).has_value());
  EXPECT_FALSE(estimate_odometry_delay({}, {}).has_value());
  Drive still = drive(10.0, 0.1);
  for (Trajectory* t : {&still.odometry, &still.poses})
    for (StampedPose& row : *t) row.stamp_s = 0.0;
  EXPECT_FALSE(estimate_odometry_delay(still.odometry, still.poses).has_value());
  const Drive sparse = drive(1.0, 0.15);  // a line between scans says nothing of it
  EXPECT_FALSE(estimate_odometry_delay(sparse.odometry, sparse.poses).has_value());
  Drive few = drive(10.0, 0.1);
  few.odometry.resize(10);
  EXPECT_FALSE(estimate_odometry_delay(few.odometry, few.poses).has_value());
}

}  // namespace
}  // namespace parloc::tools
