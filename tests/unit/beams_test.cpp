// From a scan to the beams that are weighed: which are taken, what each value means, and where each looked
// from.
#include "common/model/beams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/expect.h"
#include "tests/unit/taken_beams.h"

namespace parloc {
namespace {

using namespace test;

// ---- what a value means ----------------------------------------------------------------------------------

TEST(BeamValues, EachHasItsMeaning) {
  struct Case {
    float range_m;
    ZeroPolicy zero;
    std::size_t BeamCounts::*counted;  // null: a hit
    bool miss;
  };
  const float tiny = std::numeric_limits<float>::denorm_min();
  const ZeroPolicy invalid = ZeroPolicy::invalid, miss = ZeroPolicy::miss;
  const Case cases[] = {
      {kNan, invalid, &BeamCounts::nan, false},
      {-kInf, invalid, &BeamCounts::infinite, false},
      {kInf, invalid, &BeamCounts::misses, true},
      {-1.0f, invalid, &BeamCounts::negative, false},
      {-tiny, miss, &BeamCounts::negative, false},
      {0.0f, invalid, &BeamCounts::zero, false},
      {-0.0f, invalid, &BeamCounts::zero, false},
      {0.0f, miss, &BeamCounts::misses, true},
      {-0.0f, miss, &BeamCounts::misses, true},
      {tiny, miss, &BeamCounts::below_min, false},
      {std::nextafterf(0.5f, 0.0f), invalid, &BeamCounts::below_min, false},
      {0.5f, invalid, nullptr, false},
      {std::nextafterf(8.0f, 0.0f), invalid, nullptr, false},
      {8.0f, invalid, &BeamCounts::misses, true},
      {81.83f, invalid, &BeamCounts::misses, true},
  };
  for (const Case& c : cases) {
    Scan scan = fan(1);
    scan.ranges_m = {c.range_m};
    scan.range_min_m = 0.5;
    scan.range_max_m = 8.0;
    ScanConfig config;
    config.zero_policy = c.zero;
    const Taken t = take(scan, config);
    SCOPED_TRACE(c.range_m);
    EXPECT_EQ(t.counts.total, 1u);
    EXPECT_EQ(t.counts.considered, 1u);
    EXPECT_EQ(t.beams.hits, c.counted == nullptr ? 1u : 0u);
    EXPECT_EQ(t.beams.count, c.counted == nullptr || c.miss ? 1u : 0u);
    EXPECT_EQ(t.counts.rejected() + t.counts.misses, c.counted == nullptr ? 0u : 1u);
    if (c.counted != nullptr) {
      EXPECT_EQ(t.counts.*c.counted, 1u);
    }
    if (c.miss) {
      EXPECT_EQ(t.beams.range_m[0], 8.0f);
    }
  }
}

TEST(BeamValues, LimitsComeFromTheLidarThenTheLogThenTheScanGroup) {
  Scan scan = fan(1);
  scan.range_max_m = 0.0;
  ScanConfig config;
  config.laser_min_range = 0.3;
  config.laser_max_range = 7.0;
  const auto expect_limits = [&](double least_m, double most_m, const LidarConfig* lidar = nullptr) {
    EXPECT_EQ(lidar_setup(scan, config, lidar).range_min_m, least_m);
    EXPECT_EQ(lidar_setup(scan, config, lidar).range_max_m, most_m);
  };
  expect_limits(0.3, 7.0);
  scan.range_max_m = 20.0;
  scan.range_min_m = 0.02;
  expect_limits(0.02, 20.0);
  LidarConfig lidar;
  lidar.max_range = 5.0;
  lidar.min_range = 0.0;
  expect_limits(0.0, 5.0, &lidar);
}

// ---- which beams are taken -------------------------------------------------------------------------------

/// Indices of the beams taken, which fan() puts into their ranges.
std::vector<std::size_t> indices(const Taken& t) {
  std::vector<std::size_t> out;
  for (const float r : t.beams.range_m)
    out.push_back(static_cast<std::size_t>(std::lround((r - 1.0f) * 100.0f)));
  return out;
}

TEST(BeamChoice, EvenBeamsAreTakenByIndex) {
  ScanConfig config;
  for (const std::size_t total : {1, 2, 59, 60, 61, 180, 541}) {
    for (const int wanted : {1, 7, 60, 200}) {
      config.max_beams = wanted;
      const Taken t = take(fan(total), config);
      const std::size_t taken = std::min<std::size_t>(total, static_cast<std::size_t>(wanted));
      std::vector<std::size_t> expected;
      for (std::size_t k = 0; k < taken; ++k) expected.push_back(k * total / taken);
      EXPECT_EQ(indices(t), expected) << total << " " << wanted;
      EXPECT_EQ(t.counts.total, total);
      EXPECT_EQ(t.counts.considered, taken);
    }
  }
}

TEST(BeamChoice, BearingsThatAreEvenChangeNothing) {
  ScanConfig config;
  for (const double step_rad : {0.01, -0.013}) {
    for (const std::size_t total : {1, 2, 61, 397}) {
      const Scan scan = fan(total, 0.7, step_rad);
      Scan listed = scan;
      for (std::size_t i = 0; i < total; ++i)
        listed.bearings_rad.push_back(scan.angle_min_rad + static_cast<double>(i) * step_rad);
      for (const int wanted : {1, 7, 60, 400}) {
        config.max_beams = wanted;
        expect_same_bits(take(listed, config).beams, take(scan, config).beams);
      }
    }
  }
}

TEST(BeamChoice, UnevenBeamsAreTakenEvenlyInAngle) {
  // 100 beams to the right at 0.001 rad, 100 to the left at 0.01 rad: ten times as wide.
  Scan scan = fan(200);
  for (int i = 0; i < 100; ++i) scan.bearings_rad.push_back(-0.1 + 0.001 * i);
  for (int i = 0; i < 100; ++i) scan.bearings_rad.push_back(0.01 * i);
  ScanConfig config;
  config.max_beams = 22;
  const std::vector<std::size_t> taken = indices(take(scan, config));
  EXPECT_EQ(taken.size(), 22u);
  std::size_t right = 0;
  double widest_rad = 0.0;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    right += taken[k] < 100 ? 1 : 0;
    if (k > 0)
      widest_rad = std::max(widest_rad, scan.bearings_rad[taken[k]] - scan.bearings_rad[taken[k - 1]]);
  }
  EXPECT_EQ(right, 3u);           // parts of 0.0498 rad begin at -0.1, -0.0502, -0.0004; by index it is 11
  EXPECT_LE(widest_rad, 0.0605);  // a part, and the spacing of a beam
}

TEST(BeamChoice, NoBeamIsTakenTwice) {
  Scan scan = fan(20);
  for (int i = 0; i < 10; ++i) scan.bearings_rad.push_back(0.001 * i);
  for (int i = 0; i < 10; ++i) scan.bearings_rad.push_back(1.0 + 0.001 * i);  // nothing between
  ScanConfig config;
  config.max_beams = 10;
  const Taken t = take(scan, config);
  const std::vector<std::size_t> taken = indices(t);
  for (std::size_t k = 1; k < taken.size(); ++k) EXPECT_LT(taken[k - 1], taken[k]);
  EXPECT_EQ(t.counts.considered, taken.size());  // and it is told
  EXPECT_LT(taken.size(), 10u);
  EXPECT_GE(taken.size(), 2u);
  scan.bearings_rad.assign(20, 0.5);  // all the same: by index
  EXPECT_EQ(take(scan, config).counts.considered, 10u);
}

TEST(BeamChoice, ScansOfAnySize) {
  ScanConfig config;
  config.max_beams = 10;
  BeamTable table;
  BeamCounts counts;
  std::size_t total = 0, considered = 0;
  for (const std::size_t size : {50, 0, 3, 1, 200}) {
    const Scan scan = fan(size);
    select_beams(scan, config, SensorConfig{}, kResolution_m, table, counts);
    total += size;
    considered += std::min<std::size_t>(size, 10);
    EXPECT_EQ(table.count, std::min<std::size_t>(size, 10));
    EXPECT_EQ(table.end_x.size(), table.count);
    EXPECT_EQ(counts.total, total);
    EXPECT_EQ(counts.considered, considered);
    expect_same_bits(table, take(scan, config).beams);  // nothing is left of the scan before
  }
}

TEST(BeamChoice, RefusesArraysThatDoNotFit) {
  Scan scan = fan(3);
  scan.sensor = "front";
  scan.bearings_rad = {0, 1};
  EXPECT_EQ(error_of([&] { take(scan); }), "scan front: expected one of bearings_rad per range (3), got 2");
  scan.bearings_rad = {0, 2, 1};
  EXPECT_EQ(error_of([&] { take(scan); }), "scan front: expected bearings_rad in order");
  scan.bearings_rad = {0, 1, NAN};
  EXPECT_EQ(error_of([&] { take(scan); }), "scan front: expected bearings_rad that are finite");
  scan.bearings_rad.clear();
  scan.beam_times_s = {0, 1, 2, 3};
  EXPECT_EQ(error_of([&] { take(scan); }), "scan front: expected one of beam_times_s per range (3), got 4");
}

// ---- how the LiDAR is mounted ----------------------------------------------------------------------------

TEST(Mounting, UpsideDownIsMirrored) {
  const Scan scan = fan(60, -0.4, 0.03);
  Scan mirrored = scan;
  mirrored.angle_min_rad = -scan.angle_min_rad;
  mirrored.angle_step_rad = -scan.angle_step_rad;
  LidarConfig lidar;
  lidar.upside_down = true;
  const BeamTable beams = take(scan, {}, &lidar).beams;
  expect_same_bits(beams, take(mirrored).beams);
  // In numbers: the sensor's x axis looks along yaw, and a beam to its left goes to the right.
  const double angle = scan.T_base_sensor.theta_rad - (scan.angle_min_rad + 59 * scan.angle_step_rad);
  EXPECT_NEAR(beams.direction_x[59], std::cos(angle), 1e-7);  // float32
  EXPECT_NEAR(beams.direction_y[59], std::sin(angle), 1e-7);
  EXPECT_EQ(beams.origin_x[59], 0.2f);
  EXPECT_EQ(beams.origin_y[59], -0.1f);
}

TEST(Mounting, WhatIsConfiguredComesBeforeTheLog) {
  const Scan scan = fan(5);
  LidarConfig lidar;
  lidar.yaw = -1.0;
  Scan turned = scan;
  turned.T_base_sensor.theta_rad = -1.0;
  expect_same_bits(take(scan, {}, &lidar).beams, take(turned).beams);
  lidar.x = 0.0;
  lidar.y = 1.5;
  turned.T_base_sensor = {0.0, 1.5, -1.0};
  expect_same_bits(take(scan, {}, &lidar).beams, take(turned).beams);
}

TEST(Mounting, AnglesThatAreConfiguredComeBeforeTheLog) {
  Scan scan = fan(30), other = fan(30, 0.3, -0.02);
  LidarConfig lidar;
  lidar.angle_min = 0.3;
  lidar.angle_step = -0.02;
  expect_same_bits(take(scan, {}, &lidar).beams, take(other).beams);
  for (int i = 0; i < 30; ++i) scan.bearings_rad.push_back(0.001 * i * i);
  expect_same_bits(take(scan, {}, &lidar).beams, take(other).beams);
}

TEST(Mounting, FlippedIsUpsideDownAndTheSettingDecides) {
  LidarConfig upside_down, flipped, neither;
  upside_down.upside_down = flipped.flipped = true;
  neither.flipped = false;
  const Scan scan = fan(30, -0.4, 0.03);
  Scan said = scan;
  said.upside_down = true;
  const BeamTable mirrored = take(scan, {}, &upside_down).beams;
  expect_same_bits(take(scan, {}, &flipped).beams, mirrored);
  expect_same_bits(take(said).beams, mirrored);
  expect_same_bits(take(said, {}, &neither).beams, take(scan).beams);
}

// As if they had not been measured, whatever they say.
TEST(Mounting, MaskedBeamsAreAsNan) {
  const Scan scan = fan(63, -3.1, 0.1);
  LidarConfig lidar;
  lidar.mask = {{-0.5, 0.2}, {3.0, -3.0}};
  Scan without = scan;
  std::size_t masked = 0;
  for (std::size_t i = 0; i < 63; ++i) {
    const double bearing_rad = -3.1 + 0.1 * static_cast<double>(i);
    const bool hidden = (bearing_rad > -0.501 && bearing_rad < 0.201) || std::fabs(bearing_rad) > 2.999;
    if (hidden) without.ranges_m[i] = kNan, ++masked;
  }
  const Taken taken = take(scan, {}, &lidar);
  expect_same_bits(taken.beams, take(without).beams);
  EXPECT_EQ(taken.counts.masked, masked);
  EXPECT_EQ(taken.counts.rejected(), 0u);
  const LidarSetup setup = lidar_setup(scan, {}, &lidar);
  EXPECT_EQ(end_points(scan, setup, nullptr).size(),
            end_points(without, lidar_setup(without, {}), nullptr).size());
  // Upside down, what was on the left is on the right; the mask stays where the robot is.
  lidar.mask = {{0.05, 0.25}};
  lidar.upside_down = true;
  Scan left_out = scan;
  left_out.ranges_m[30] = left_out.ranges_m[29] = kNan;  // -0.1 and -0.2
  LidarConfig mirrored;
  mirrored.upside_down = true;
  expect_same_bits(take(scan, {}, &lidar).beams, take(left_out, {}, &mirrored).beams);
}

// ---- when each beam was taken ----------------------------------------------------------------------------

// A LiDAR whose geometry changes between scans, and one that moves while it scans, in between.
TEST(Mounting, DirectionsAreRememberedOnlyAsLongAsNothingChanges) {
  LidarConfig turned, mirrored;
  turned.yaw = 0.7;
  mirrored.upside_down = true;
  OdometryTrack track(MotionConfig{});
  for (int k = 0; k < 6; ++k) track.add(99.9 + 0.05 * k, {0.02 * k, 0.0, 0.01 * k});
  Scan uneven = fan(40);
  for (int i = 0; i < 40; ++i) uneven.bearings_rad.push_back(0.001 * i * i);
  Scan less_uneven = uneven;
  less_uneven.bearings_rad[20] += 0.01;
  struct Turn {
    Scan scan;
    const LidarConfig* lidar = nullptr;
    const OdometryTrack* track = nullptr;
  };
  const Turn turns[] = {{fan(40)},     {fan(40)},       {fan(40), &turned},         {fan(40), &mirrored},
                        {fan(41)},     {fan(41, -1.9)}, {fan(41, -1.9, 0.02)},      {uneven},
                        {less_uneven}, {fan(40)},       {fan(40), nullptr, &track}, {fan(40)}};
  BeamDirections directions;
  for (const Turn& t : turns) {
    ScanConfig config;
    config.max_beams = 30;
    config.scan_time = t.track != nullptr ? 0.1 : 0.0;
    Taken with;
    select_beams(t.scan, lidar_setup(t.scan, config, t.lidar), t.track, SensorConfig{}, kResolution_m,
                 with.beams, with.counts, &directions);
    expect_same_bits(with.beams, take(t.scan, config, t.lidar, t.track).beams);
  }
}

}  // namespace
}  // namespace parloc
