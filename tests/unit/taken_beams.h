// Scans of beams in a fan, and the beams that are taken of them.
#pragma once

#include <gtest/gtest.h>

#include <limits>

#include "common/model/beams.h"

namespace parloc::test {

constexpr double kResolution_m = 0.05;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

struct Taken {
  BeamTable beams;
  BeamCounts counts;
};
inline Taken take(const Scan& scan, const ScanConfig& config = {}, const LidarConfig* lidar = nullptr,
                  const OdometryTrack* track = nullptr) {
  Taken t;
  select_beams(scan, lidar_setup(scan, config, lidar), track, SensorConfig{}, kResolution_m, t.beams,
               t.counts);
  return t;
}

inline Scan fan(std::size_t beams, double angle_min_rad = -2.0, double angle_step_rad = 0.01) {
  Scan s{.stamp_s = 100.0,
         .T_base_sensor = {0.2, -0.1, 0.3},
         .angle_min_rad = angle_min_rad,
         .angle_step_rad = angle_step_rad,
         .range_max_m = 10.0};
  for (std::size_t i = 0; i < beams; ++i) s.ranges_m.push_back(1.0f + 0.01f * static_cast<float>(i));
  return s;
}

inline void expect_same_bits(const BeamTable& a, const BeamTable& b) {
  EXPECT_EQ(a.count, b.count);
  EXPECT_EQ(a.hits, b.hits);
  EXPECT_EQ(a.origin_spread_m, b.origin_spread_m);
  for (const auto field :
       {&BeamTable::origin_x, &BeamTable::origin_y, &BeamTable::direction_x, &BeamTable::direction_y,
        &BeamTable::range_m, &BeamTable::short_density, &BeamTable::end_x, &BeamTable::end_y})
    EXPECT_EQ(a.*field, b.*field);
}

}  // namespace parloc::test
