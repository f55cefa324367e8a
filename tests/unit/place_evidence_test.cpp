// Places that look alike from one spot and not along the way there.
#include "common/localize/place_evidence.h"

#include <gtest/gtest.h>

#include "common/io/log.h"
#include "common/search/pose_rays.h"
#include "tests/unit/localize_scenes.h"

namespace parloc {
namespace {

constexpr double kEffectiveBeams = 6.0;

/// 30 x 4 m, all the same but for a column at x = 5 m.
GridMap corridor_with_column() {
  std::vector<std::string> rows(40, "#" + std::string(298, '.') + "#");
  rows.front() = rows.back() = std::string(300, '#');
  for (int j = 1; j < 12; ++j) rows[j].replace(50, 4, "####");
  return grid_from_text(rows, 0.1);
}

/// 91 beams all around that reach 4 m, without noise.
BeamTable seen_from(const GridMap& map, const Pose& pose) {
  const PoseRays rays(map);
  Scan scan{
      .angle_min_rad = -M_PI, .angle_step_rad = 2.0 * M_PI / 91.0, .range_min_m = 0.1, .range_max_m = 4.0};
  for (int k = 0; k < 91; ++k) {
    const double heading = pose.theta_rad + scan.angle_min_rad + k * scan.angle_step_rad;
    scan.ranges_m.push_back(rays.cast(static_cast<float>(pose.x_m), static_cast<float>(pose.y_m),
                                      static_cast<float>(heading), 4.0f));
  }
  return ParticleFilter(test::small_localizer(), map).beams(scan);
}

struct Corridor {
  GridMap map = corridor_with_column();
  Pose here{14.0, 2.0, 0.0}, there{22.0, 2.0, 0.0};  // neither sees the column or an end
  BeamTable beams = seen_from(map, here);
  Pose odometry{100.0, 50.0, 1.0};  // of its own frame

  /// The drive that ends here, from `back_m` behind.
  void drive(PlaceEvidence& judge, double back_m) const {
    for (double left_m = back_m; left_m > 0.0; left_m -= 0.5)
      judge.remember(compose(odometry, {-left_m, 0.0, 0.0}), seen_from(map, {here.x_m - left_m, 2.0, 0.0}));
  }
};

TEST(PlaceEvidence, OneScanOfACorridorTellsNothing) {
  const Corridor c;
  PlaceEvidence judge(c.map, kEffectiveBeams);
  const auto said = judge.judge({c.here, c.there}, c.odometry, c.beams);
  EXPECT_NEAR(said[0].share, 0.5, 0.02);  // cells seen at other angles: not quite the same ranges
  EXPECT_NEAR(said[0].share + said[1].share, 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(said[0].evidence, judge.evidence(c.beams, c.here));
}

TEST(PlaceEvidence, TheWayThereTells) {
  const Corridor c;
  PlaceEvidence judge(c.map, kEffectiveBeams);
  // Six scans 0.5 m apart: from the first ones, 8 m behind at most, the column was seen.
  for (const double back_m : {8.0, 7.5, 7.0, 6.5, 6.0, 5.5})
    judge.remember(compose(c.odometry, {-back_m, 0.0, 0.0}),
                   seen_from(c.map, {c.here.x_m - back_m, 2.0, 0.0}));
  const auto said = judge.judge({c.there, c.here}, c.odometry, c.beams);
  EXPECT_GT(said[1].share, 0.9);  // the column is in few beams of half the scans
  EXPECT_GT(said[1].evidence, said[0].evidence + 0.1);
  judge.forget();
  EXPECT_NEAR(judge.judge({c.there, c.here}, c.odometry, c.beams)[1].share, 0.5, 0.02);
}

TEST(PlaceEvidence, WhatIsFarBehindIsForgotten) {
  const Corridor c;
  PlaceEvidence judge(c.map, kEffectiveBeams);
  c.drive(judge, 8.0);  // 16 scans; the last six are within 3 m, where there is no column to be seen
  EXPECT_NEAR(judge.judge({c.there, c.here}, c.odometry, c.beams)[1].share, 0.5, 0.05);
}

TEST(PlaceEvidence, StandingStillAddsNothing) {
  const Corridor c;
  PlaceEvidence judge(c.map, kEffectiveBeams);
  const Pose by_the_column{c.here.x_m - 8.0, 2.0, 0.0};
  const Pose odometry = compose(c.odometry, {-8.0, 0.0, 0.0});
  judge.remember(odometry, seen_from(c.map, by_the_column));
  const auto once = judge.judge({c.there, c.here}, c.odometry, c.beams);
  for (int k = 0; k < 20; ++k) judge.remember(compose(odometry, {0.01 * k, 0.0, 0.01 * k}), c.beams);
  const auto again = judge.judge({c.there, c.here}, c.odometry, c.beams);
  EXPECT_EQ(once[1].share, again[1].share);
}

TEST(PlaceEvidence, NothingToJudge) {
  const Corridor c;
  PlaceEvidence judge(c.map, kEffectiveBeams);
  EXPECT_TRUE(judge.judge({}, c.odometry, c.beams).empty());
  judge.remember(c.odometry, BeamTable{});  // no beams: not worth remembering
  const auto said = judge.judge({c.here, c.there}, c.odometry, BeamTable{});
  EXPECT_EQ(said[0].evidence, 0.0);
  EXPECT_EQ(said[0].share, 0.5);
}

}  // namespace
}  // namespace parloc
