// When each beam of a scan was taken, and where the robot was then.
#include <gtest/gtest.h>

#include <cmath>

#include "common/model/beams.h"
#include "tests/unit/taken_beams.h"

namespace parloc {
namespace {

using namespace test;

TEST(BeamTime, GoesFromTheFirstBeamToTheLastAroundTheStamp) {
  const Scan scan = fan(5);
  ScanConfig config;
  config.scan_time = 0.1;
  for (const auto& [at, first_s] :
       {std::pair{StampAt::first, 0.0}, {StampAt::middle, -0.05}, {StampAt::last, -0.1}}) {
    config.stamp_at = at;
    const LidarSetup setup = lidar_setup(scan, config);
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_NEAR(beam_time_s(scan, setup, i), first_s + 0.025 * static_cast<double>(i), 1e-15);
    EXPECT_NEAR(latest_beam_s(scan, setup), first_s + 0.1, 1e-15);
    EXPECT_TRUE(takes_time(scan, setup));
  }
  EXPECT_EQ(latest_beam_s(Scan{}, lidar_setup(Scan{}, config)), 0.0);
  EXPECT_FALSE(takes_time(fan(1), lidar_setup(fan(1), config)));
}

TEST(BeamTime, ComesFromTheLidarThenTheLogThenTheScanGroup) {
  Scan scan = fan(3);
  ScanConfig config;
  EXPECT_FALSE(takes_time(scan, lidar_setup(scan, config)));
  config.scan_time = 0.1;
  EXPECT_EQ(beam_time_s(scan, lidar_setup(scan, config), 2), 0.1);
  scan.scan_time_s = 0.2;
  EXPECT_EQ(beam_time_s(scan, lidar_setup(scan, config), 2), 0.2);
  scan.beam_times_s = {-0.3, 0.0, 0.5};
  EXPECT_EQ(beam_time_s(scan, lidar_setup(scan, config), 0), -0.3);
  EXPECT_EQ(latest_beam_s(scan, lidar_setup(scan, config)), 0.5);
  LidarConfig lidar;
  lidar.scan_time = 0.0;
  EXPECT_FALSE(takes_time(scan, lidar_setup(scan, config, &lidar)));
  lidar.scan_time = 0.05;
  EXPECT_EQ(beam_time_s(scan, lidar_setup(scan, config, &lidar), 2), 0.05);
}

// ---- deskewing -------------------------------------------------------------------------------------------

/// Where a drive along an arc is after a time, in closed form and libm's arithmetic.
Pose on_arc(double speed_mps, double turn_rad_s, double t) {
  const double a = turn_rad_s * t;
  const double chord = a == 0.0 ? speed_mps * t : speed_mps * t * std::sin(a / 2) / (a / 2);
  return {chord * std::cos(a / 2), chord * std::sin(a / 2), a};
}
/// Readings every 50 ms around the scan's stamp.
OdometryTrack arc(double speed_mps, double turn_rad_s) {
  OdometryTrack track(MotionConfig{});
  for (int k = -3; k <= 4; ++k)
    track.add(100.0 + 0.05 * k, compose({5.0, -3.0, 2.0}, on_arc(speed_mps, turn_rad_s, 0.05 * k)));
  return track;
}

TEST(Deskewing, PutsEveryBeamWhereItWasTaken) {
  for (const double speed_mps : {0.0, 1.5}) {
    for (const double turn_rad_s : {0.0, 1.0, -2.5}) {
      for (const StampAt at : {StampAt::first, StampAt::middle, StampAt::last}) {
        const OdometryTrack track = arc(speed_mps, turn_rad_s);
        Scan scan = fan(200, -3.0, 0.03);
        scan.ranges_m[20] = scan.ranges_m[90] = kInf;
        ScanConfig config;
        config.max_beams = 50;
        config.scan_time = 0.1;
        config.stamp_at = at;
        const BeamTable beams = take(scan, config, nullptr, &track).beams;
        ASSERT_EQ(beams.count, 50u);
        ASSERT_EQ(beams.hits, 49u);  // of the two, 20 is among those taken
        for (std::size_t m = 0; m < beams.hits; ++m) {
          const auto i = static_cast<double>(std::lround((beams.range_m[m] - 1.0f) * 100.0f));
          const double t = 0.1 * (i / 199.0 - (at == StampAt::first    ? 0.0
                                               : at == StampAt::middle ? 0.5
                                                                       : 1.0));
          const Pose robot = on_arc(speed_mps, turn_rad_s, t);
          const double c = std::cos(robot.theta_rad), s = std::sin(robot.theta_rad);
          const double ox = robot.x_m + c * 0.2 + s * 0.1, oy = robot.y_m + s * 0.2 - c * 0.1;
          const double angle = robot.theta_rad + 0.3 - 3.0 + 0.03 * i;
          const double r = beams.range_m[m];
          // float32 of up to 3 m, and of up to 60 cells; the stamps near 100 s have 1.4e-14.
          EXPECT_NEAR(beams.origin_x[m], ox, 2e-7);
          EXPECT_NEAR(beams.origin_y[m], oy, 2e-7);
          EXPECT_NEAR(beams.direction_x[m], std::cos(angle), 1e-7);
          EXPECT_NEAR(beams.direction_y[m], std::sin(angle), 1e-7);
          EXPECT_NEAR(beams.end_x[m], (ox + r * std::cos(angle)) / kResolution_m, 8e-6);
          EXPECT_NEAR(beams.end_y[m], (oy + r * std::sin(angle)) / kResolution_m, 8e-6);
        }
        EXPECT_EQ(beams.origin_spread_m > 1e-3, speed_mps != 0.0 || turn_rad_s != 0.0);
      }
    }
  }
}

TEST(Deskewing, OfAStandingRobotChangesNothing) {
  OdometryTrack track(MotionConfig{});
  for (int k = 0; k < 6; ++k) track.add(99.9 + 0.05 * k, {5.0, -3.0, 2.0});
  const Scan scan = fan(397, -3.0, 0.015);
  ScanConfig config;
  const BeamTable instant = take(scan, config).beams;
  for (const StampAt at : {StampAt::first, StampAt::middle, StampAt::last}) {
    config.scan_time = 0.1;
    config.stamp_at = at;
    expect_same_bits(take(scan, config, nullptr, &track).beams, instant);
  }
}

TEST(Deskewing, EndPointsOfPicturesAreThoseOfTheBeams) {
  const OdometryTrack track = arc(1.0, 1.0);
  Scan scan = fan(60);
  scan.ranges_m[3] = kNan;
  scan.ranges_m[4] = kInf;
  ScanConfig config;
  config.scan_time = 0.1;
  const BeamTable beams = take(scan, config, nullptr, &track).beams;
  const std::vector<EndPoint> points = end_points(scan, lidar_setup(scan, config), &track);
  ASSERT_EQ(points.size(), beams.hits);
  for (std::size_t m = 0; m < points.size(); ++m) {
    EXPECT_NEAR(points[m].x_m, beams.end_x[m] * kResolution_m, 1e-6);
    EXPECT_NEAR(points[m].y_m, beams.end_y[m] * kResolution_m, 1e-6);
  }
}

}  // namespace
}  // namespace parloc
