// Correlative search of a window of poses, against all of its poses one by one.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/error.h"
#include "common/filter/bind.h"
#include "common/simulator/simulator.h"
#include "common/slam/slam_backend.h"
#include "cpu/draft_maps.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

Scan scan_from(const GridMap& map, const Pose& pose) {
  Scan s{.angle_min_rad = -3.0, .angle_step_rad = 6.0 / 120.0, .range_max_m = 6.0};
  for (std::size_t i = 0; i < 120; ++i) {
    const double angle = pose.theta_rad + s.angle_min_rad + static_cast<double>(i) * s.angle_step_rad;
    s.ranges_m.push_back(static_cast<float>(cast_simulated_ray(map, pose.x_m, pose.y_m, angle, 6.0).range_m));
  }
  return s;
}

class WideSearchIn : public testing::Test {
 protected:
  WideSearchIn() : rules_(bind_matcher_rules(config_)), draft_(rules_, 1), matcher_(fresh_matcher()) {
    std::vector<ScanDrawing> drawings;
    for (int k = 0; k < 5; ++k) {
      const Pose pose{0.8 + 0.1 * k, 1.5, 0.1 * k};
      drawings.push_back({0, &table(pose), at(pose)});
    }
    draft_.draw(drawings);
    matcher_->draw(drawings);
  }
  std::unique_ptr<ScanMatcher> fresh_matcher() const { return make_cpu_scan_matcher({rules_, 1, 0}); }
  Pose at(const Pose& p) const { return compose(room_.T_map_grid, p); }
  SlamPose slam(const Pose& p) const { return slam_pose(at(p)); }
  const BeamTable& table(const Pose& p) {
    BeamCounts counts;
    tables_.push_back(std::make_unique<BeamTable>());
    select_beams(scan_from(room_, at(p)), ScanConfig{}, SensorConfig{}, config_.resolution, *tables_.back(),
                 counts);
    return *tables_.back();
  }
  Beams beams(const Pose& p) { return bind_beams(table(p)); }

  GridMap room_ = test::room_of_blocks(test::rows_with_blocks_and_wall());
  SlamConfig config_;
  MatcherRules rules_;
  cpu::DraftMaps draft_;
  std::unique_ptr<ScanMatcher> matcher_;  ///< With the same map.
  std::vector<std::unique_ptr<BeamTable>> tables_;
};

// What makes the coarse level worth its while, and must hold for the answer to be the best one.
TEST_F(WideSearchIn, BoundsNoPoseOfABlockScoresMore) {
  const Beams scan = beams({1.0, 1.6, 0.2});
  const TileMap map = draft_.view(0);
  int tight = 0;
  for (int n = 0; n < 60; ++n) {
    const SlamPose low = slam({0.3 + 0.031 * n, 1.1 + 0.017 * n, 0.2 - 0.01 * (n % 7)});
    const std::int32_t bound =
        sum_beams(map, scan, match_pose(low, rules_.match), rules_.match, Ask::bound, 0, 1);
    for (int k = 0; k < 64; ++k) {
      SlamPose p = low;
      p.x += static_cast<float>(k % 8) * 0.05f, p.y += static_cast<float>(k / 8) * 0.05f;
      const std::int32_t score =
          sum_beams(map, scan, match_pose(p, rules_.match), rules_.match, Ask::score, 0, 1);
      EXPECT_LE(score, bound);
      tight += 2 * score > bound ? 1 : 0;
    }
  }
  EXPECT_GT(tight, 10);  // else the bounds would be good for nothing
}

TEST_F(WideSearchIn, FindsWhatAllPosesOneByOneGive) {
  const SearchRules search = bind_search_rules(config_.resolution, 0.45, 0.15, 0.05);
  const TileMap map = draft_.view(0);
  for (int n = 0; n < 6; ++n) {
    const Beams scan = beams({1.0 + 0.05 * n, 1.6, 0.2});
    const SlamPose start = slam({1.0 + 0.05 * n + 0.3 - 0.1 * n, 1.6 - 0.25, 0.2 + 0.12});
    const auto sum_at = [&](const SlamPose& p, Ask ask) {
      return sum_beams(map, scan, match_pose(p, rules_.match), rules_.match, ask, 0, 1);
    };
    const auto score = [&](const SlamPose& p) { return sum_at(p, Ask::score); };
    WideSearch wide;
    wide.begin(start, search, scan.hits);
    std::vector<std::int32_t> bound(WideSearch::kMostBlocks);
    int asked = 0;
    while (!wide.done()) {
      std::int32_t sum[WideSearch::kBatch];
      for (int k = 0; k < wide.wanted(); ++k, ++asked)
        sum[k] = sum_at(wide.candidate(k, search), wide.asks_bounds() ? Ask::bound : Ask::score);
      wide.take(sum, bound.data(), search);
    }
    double best = 0.0;
    for (int turn = -search.turns; turn <= search.turns; ++turn)
      for (int j = -search.cells; j <= search.cells; ++j)
        for (int i = -search.cells; i <= search.cells; ++i) {
          const SlamPose p{start.x + static_cast<float>(i) * 0.05f, start.y + static_cast<float>(j) * 0.05f,
                           wrap(start.theta + static_cast<float>(turn) * search.step_theta)};
          const double bias =
              (i * i + j * j) / 81.0 + turn * turn / static_cast<double>(search.turns * search.turns);
          best = std::max(best, score(p) - 0.05 * 65536.0 * static_cast<double>(scan.hits) * bias);
        }
    const SlamPose& p = wide.pose();
    const double i = (p.x - start.x) / 0.05, j = (p.y - start.y) / 0.05;
    const double turn = wrap(p.theta - start.theta) / search.step_theta;
    const double bias = (i * i + j * j) / 81.0 + turn * turn / (search.turns * search.turns);
    EXPECT_NEAR(score(p) - 0.05 * 65536.0 * static_cast<double>(scan.hits) * bias, best, 50.0);
    EXPECT_LT(asked, 21 * 19 * 19 / 3);  // of the window's poses
  }
}

// The climb alone ends on a lesser peak from there.
TEST_F(WideSearchIn, FindsTheWayBackFromHalfAMetreAside) {
  const Pose truth{1.1, 1.6, 0.3};
  const BeamTable& scan = table(truth);
  const Pose start = at({1.1 + 0.4, 1.6 - 0.4, 0.3 + 0.2}), goal = at(truth);
  const SearchRules search = bind_search_rules(config_.resolution, 0.5, 0.3, 0.05);
  const std::vector<ScanMatch> matches =
      matcher_->match({{0, &scan, start, rules_.climb, search}, {0, &scan, start, rules_.climb, {}}});
  const ScanMatch &found = matches[0], &climbed = matches[1];
  expect_near(found.pose, goal, 0.03, 0.02);
  EXPECT_GT(found.fit, 0.7);
  EXPECT_LT(climbed.fit, 0.6);
}

// As much bias as there can be, for as many beams: nothing runs over, and the start is kept.
TEST_F(WideSearchIn, ALargeBiasHoldsItAtItsStart) {
  const SearchRules search = bind_search_rules(config_.resolution, 0.5, 0.3, 1.0);
  WideSearch wide;
  const SlamPose start{1.0f, 2.0f, 0.5f};
  wide.begin(start, search, kMostDrawnBeams);
  const std::int32_t all = static_cast<std::int32_t>(kMostDrawnBeams) * 65536;
  std::vector<std::int32_t> bound(WideSearch::kMostBlocks), sum(WideSearch::kBatch, all);
  for (int rounds = 0; !wide.done() && rounds < WideSearch::kMostRounds; ++rounds)
    wide.take(sum.data(), bound.data(), search);  // all poses fit alike
  EXPECT_TRUE(wide.done());
  EXPECT_EQ(wide.pose().x, start.x);
  EXPECT_EQ(wide.pose().y, start.y);
  EXPECT_EQ(wide.pose().theta, start.theta);
}

TEST_F(WideSearchIn, StaysWhereNothingFits) {
  const SearchRules search = bind_search_rules(config_.resolution, 0.5, 0.3, 0.05);
  const ScanMatch found =
      fresh_matcher()->match({{0, &table({1.0, 1.5, 0.0}), {5.0, 6.0, 0.75}, rules_.climb, search}})[0];
  expect_equal(found.pose, {5.0, 6.0, 0.75});
  EXPECT_EQ(found.fit, 0.0f);
}

TEST(SearchRules, WindowsTooLargeAreRefused) {
  EXPECT_NO_THROW(bind_search_rules(SlamConfig{}.resolution, 1.0, 0.4, 0.1));
  EXPECT_THROW(bind_search_rules(SlamConfig{}.resolution, 5.0, 3.1, 0.1), Error);
}

}  // namespace
}  // namespace parloc
