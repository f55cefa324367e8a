// What a map of cells leaves open, by how the walls of a scan hold the pose.
#include "common/localize/map_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "common/localize/health.h"
#include "common/localize/missing_returns.h"
#include "tests/unit/localize_scenes.h"

namespace parloc {
namespace {

constexpr double kCell_m = 0.05;

/// A scan from the origin of `view_rad` about `ahead_rad`, and the walls that it should see: given by
/// distance.
struct Seen {
  BeamTable beams;
  std::vector<float> expected_m;

  template <class Range>
  Seen(int count, double ahead_rad, double view_rad, Range range_m) {
    for (int k = 0; k < count; ++k) {
      const double a = ahead_rad + view_rad * ((k + 0.5) / count - 0.5);
      beams.origin_x.push_back(0.0F), beams.origin_y.push_back(0.0F);
      beams.direction_x.push_back(static_cast<float>(std::cos(a)));
      beams.direction_y.push_back(static_cast<float>(std::sin(a)));
      beams.range_m.push_back(static_cast<float>(range_m(a)));
    }
    beams.count = beams.hits = static_cast<std::size_t>(count);
    expected_m = beams.range_m;
  }
};

double room(double a) {  // 8 x 6 m, the robot in its middle
  return std::fmin(4.0 / std::fabs(std::cos(a)), 3.0 / std::fabs(std::sin(a)));
}
double corridor(double a) {  // 3 m wide, along x, without ends: 40 m are far enough
  return std::fmin(1.5 / std::fabs(std::sin(a)), 40.0);
}

TEST(MapError, WallsAllAroundCancel) {
  const Seen seen(360, 0.0, 2.0 * M_PI, room);
  const WallGeometry walls = wall_geometry(seen.beams, seen.expected_m, kCell_m);
  ASSERT_TRUE(walls.known);
  EXPECT_NEAR(walls.all_farther[0], 0.0, 0.05);
  EXPECT_NEAR(walls.all_farther[1], 0.0, 0.05);
  EXPECT_NEAR(walls.all_farther[2], 0.0, 0.05);
}

TEST(MapError, AWallAheadMovesThePoseWithIt) {
  // 90 degrees straight at a wall: the whole of its error is the pose's, in the direction that it is looked
  // in.
  const Seen seen(180, 0.0, M_PI / 2.0, [](double a) { return 4.0 / std::cos(a); });
  const WallGeometry walls = wall_geometry(seen.beams, seen.expected_m, kCell_m);
  ASSERT_TRUE(walls.known);
  EXPECT_NEAR(walls.all_farther[0], 1.0, 0.05);
  EXPECT_NEAR(walls.all_farther[1], 0.0, 0.05);
  const Covariance ahead = map_error(walls, 0.0, kCell_m), left = map_error(walls, M_PI / 2.0, kCell_m);
  EXPECT_NEAR(std::sqrt(ahead.v[0]), 0.5 * kCell_m, 0.3 * kCell_m);
  EXPECT_NEAR(ahead.v[0], left.v[4], 1e-12);  // the same in the frame of the map, turned with the robot
  EXPECT_NEAR(ahead.v[4], left.v[0], 1e-12);
}

TEST(MapError, ACorridorHoldsNothingAlongIt) {
  const Seen seen(360, 0.0, 2.0 * M_PI, corridor);
  const WallGeometry walls = wall_geometry(seen.beams, seen.expected_m, kCell_m);
  ASSERT_TRUE(walls.known);
  EXPECT_GT(walls.each_off[0], 10.0 * walls.each_off[4]);
}

TEST(MapError, IsSymmetricAndPositiveAndSmallWithoutWalls) {
  Seen nothing(10, 0.0, 1.0, [](double) { return 5.0; });
  nothing.expected_m.assign(10, 1.0F);  // no beam ends where the map has a wall
  const WallGeometry none = wall_geometry(nothing.beams, nothing.expected_m, kCell_m);
  EXPECT_FALSE(none.known);
  const Covariance rest = map_error(none, 0.3, kCell_m);
  EXPECT_GT(rest.v[0], 0.0);
  EXPECT_LT(std::sqrt(rest.v[0]), kCell_m);
  const Seen seen(200, 0.7, 2.0, room);
  const Covariance map = map_error(wall_geometry(seen.beams, seen.expected_m, kCell_m), 0.3, kCell_m);
  EXPECT_DOUBLE_EQ(map.v[1], map.v[3]);
  EXPECT_GT(map.v[0] * map.v[4] - map.v[1] * map.v[1], 0.0);
}

TEST(MissingReturns, LearnsWhatIsLostAndNotWhatIsOpen) {
  const Seen whole(180, 0.0, 2.0, room);
  BeamTable thinned = whole.beams, open = whole.beams;
  const auto keep = [](BeamTable& table, auto draw) {
    std::vector<bool> hit;
    for (std::size_t m = 0; m < table.count; ++m) hit.push_back(draw(m));
    BeamTable hits_first = table;
    std::size_t to = 0, hits = 0;
    for (const bool wanted : {true, false}) {
      for (std::size_t m = 0; m < table.count; ++m) {
        if (hit[m] != wanted) continue;
        for (const auto array : {&BeamTable::direction_x, &BeamTable::direction_y, &BeamTable::range_m})
          (hits_first.*array)[to] = (table.*array)[m];
        ++to;
        hits += wanted ? 1 : 0;
      }
    }
    hits_first.hits = hits;
    table = hits_first;
  };
  std::mt19937 random(1);
  std::bernoulli_distribution arrives(0.6);
  MissingReturns lossy, sound;
  for (int k = 0; k < 200; ++k) {
    thinned = open = whole.beams;
    keep(thinned, [&](std::size_t) { return arrives(random); });
    keep(open, [](std::size_t m) { return m < 90; });  // half of it looks out of the door
    lossy.add(thinned, 1.0), sound.add(open, 1.0);
  }
  // About 50 scans count, with 65 beams each that are asked: 0.01 is the standard error.
  EXPECT_NEAR(lossy.share(), 0.4, 0.04);
  EXPECT_LT(sound.share(), 0.01);
  MissingReturns standing;
  for (int k = 0; k < 100; ++k) standing.add(thinned, 0.0);
  EXPECT_EQ(standing.share(), 0.0);  // nothing new was seen
}

TEST(ProbabilityWithin, IsTheNormalDistributions) {
  Covariance sharp;
  EXPECT_DOUBLE_EQ(probability_within(sharp), 1.0);
  Covariance along;
  along.v[0] = 0.25;  // 0.5 m is one standard deviation
  EXPECT_NEAR(probability_within(along), 0.682689, 1e-5);
  Covariance turned;  // the same, along a diagonal
  turned.v[0] = turned.v[1] = turned.v[3] = turned.v[4] = 0.125;
  EXPECT_NEAR(probability_within(turned), 0.682689, 1e-5);
  Covariance heading;
  heading.v[8] = std::pow(10.0 * M_PI / 180.0 / 2.0, 2);  // two of them
  EXPECT_NEAR(probability_within(heading), 0.954500, 1e-5);
  Covariance nothing;
  nothing.v[0] = NAN;
  EXPECT_EQ(probability_within(nothing), 0.0);
}

}  // namespace
}  // namespace parloc
