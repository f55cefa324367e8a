// Whole runs of grid SLAM on a simulated drive, whose truth is known (SPEC 13.5, gate S1).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/eval/metrics.h"
#include "common/slam/grid_slam.h"
#include "tests/unit/simulated.h"

namespace parloc {
namespace {

GridSlamConfig config(SlamProposal proposal, std::int64_t particles, std::uint64_t seed = 1) {
  GridSlamConfig c;
  c.slam.proposal = proposal;
  c.slam.particles = particles;
  c.scan.max_beams = 120;
  c.seed = seed;
  return c;
}

void run(GridSlam& slam) {
  for (const LogRecord& record : hall_drive().records) {
    if (record.kind == RecordKind::odometry)
      slam.add_odometry(record.stamp_s, record.odometry);
    else
      slam.step(record.odometry, record.scan);
  }
}

std::vector<Relation> consecutive_relations(const GridSlam& slam) {
  std::vector<double> stamps;
  for (const SlamRecord& r : slam.records()) stamps.push_back(r.stamp_s);
  const auto at = truth_at(truth_of_hall_drive(), stamps);
  std::vector<Relation> relations;
  for (std::size_t k = 1; k < at.size(); ++k)
    relations.push_back({stamps[k - 1], stamps[k], relative(*at[k], *at[k - 1])});
  return relations;
}

struct Accuracy {
  double rmse_m;
  RelationErrors relations;
};
Accuracy accuracy(SlamProposal proposal, std::int64_t particles, std::uint64_t seed) {
  GridSlam slam(config(proposal, particles, seed));
  run(slam);
  return {compare_tracks(slam.trajectory(), truth_of_hall_drive()).position_rmse_m,
          compare_relations(slam.trajectory(), consecutive_relations(slam))};
}

TEST(GridSlam, MatchedScansGiveTheTrajectory) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Accuracy a = accuracy(SlamProposal::scan_match, 30, seed);
    EXPECT_LT(a.rmse_m, 0.10) << seed;
    EXPECT_LT(a.relations.translation_mean_m, 0.035) << seed;
    EXPECT_LT(a.relations.rotation_mean_rad, 0.010) << seed;
  }
}

TEST(GridSlam, TheGaussianProposalGivesTheTrajectory) {
  for (const std::uint64_t seed : {1, 2, 3})
    EXPECT_LT(accuracy(SlamProposal::gaussian, 15, seed).rmse_m, 0.12) << seed;
}

TEST(GridSlam, OdometryAloneProposesWorse) {
  double motion_m = 0.0, matched_m = 0.0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    motion_m += accuracy(SlamProposal::motion, 15, seed).rmse_m;
    matched_m += accuracy(SlamProposal::scan_match, 15, seed).rmse_m;
  }
  EXPECT_GT(motion_m, matched_m);
}

// Most cells within the walls that were seen are as the true map has them.
TEST(GridSlam, TheMapIsTheHall) {
  GridSlam slam(config(SlamProposal::scan_match, 30));
  run(slam);
  const GridMap map = slam.map();
  const Pose T_hall_map = hall_drive().truth.front().pose;
  std::size_t free_right = 0, free_all = 0, wall_right = 0, wall_all = 0;
  const GridMap& hall = fine_hall();
  const auto wall_near = [&](double x_m, double y_m) {
    for (double dy = -0.1; dy <= 0.1; dy += 0.02)
      for (double dx = -0.1; dx <= 0.1; dx += 0.02)
        if (hall.at_point(x_m + dx, y_m + dy) == Cell::occupied) return true;
    return false;
  };
  for (std::int32_t j = 0; j < map.height; ++j)
    for (std::int32_t i = 0; i < map.width; ++i) {
      const Pose at = compose(compose(T_hall_map, map.T_map_grid),
                              {(i + 0.5) * map.resolution_m, (j + 0.5) * map.resolution_m, 0.0});
      if (map.at(i, j) == Cell::free) {
        ++free_all;
        free_right += hall.at_point(at.x_m, at.y_m) == Cell::free ? 1 : 0;
      } else if (map.at(i, j) == Cell::occupied) {
        ++wall_all;
        wall_right += wall_near(at.x_m, at.y_m) ? 1 : 0;
      }
    }
  EXPECT_GT(wall_all, 500u);
  EXPECT_GT(static_cast<double>(wall_right), 0.95 * static_cast<double>(wall_all));
  EXPECT_GT(static_cast<double>(free_right), 0.98 * static_cast<double>(free_all));
}

TEST(GridSlam, WhatSawNothingClearsItsWayIfItIsToldTo) {
  Scan scan{.angle_min_rad = -1.0, .angle_step_rad = 0.02, .range_max_m = 3.0};
  for (int k = 0; k < 101; ++k)
    scan.ranges_m.push_back(k % 10 == 0 ? 1.0f : std::numeric_limits<float>::infinity());
  const double bearing_rad = -1.0 + 55 * 0.02;  // saw nothing
  for (const double clear_m : {0.0, 2.0, 9.0}) {
    SCOPED_TRACE(clear_m);
    GridSlamConfig c = config(SlamProposal::gaussian, 1);
    c.slam.clear_range = clear_m;
    GridSlam slam(c);
    slam.step({}, scan);
    const GridMap map = slam.map();
    for (const double range_m : {1.5, 1.9, 2.2, 2.9, 3.2}) {
      const Cell seen = map.at_point(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad));
      EXPECT_EQ(seen, range_m < std::min(clear_m, 3.0) ? Cell::free : Cell::unknown) << range_m;
    }
    // A wall that other beams pass at a hand's breadth is one all the same, mostly.
    EXPECT_GE(std::count(map.cells.begin(), map.cells.end(), Cell::occupied), 8);
  }
}

TEST(GridSlam, SameSeedSameMapAtAnyNumberOfThreads) {
  const auto digest = [](int threads, std::uint64_t seed) {
    GridSlamConfig c = config(SlamProposal::scan_match, 7, seed);
    c.threads = threads;
    GridSlam slam(c);
    run(slam);
    return slam.digest();
  };
  EXPECT_EQ(digest(1, 5), digest(3, 5));
  EXPECT_NE(digest(1, 5), digest(1, 6));
}

TEST(GridSlam, SaysWhatItDid) {
  GridSlam slam(config(SlamProposal::scan_match, 10));
  run(slam);
  EXPECT_EQ(slam.trajectory().size(), hall_drive().truth.size());
  EXPECT_EQ(slam.trajectory().front().pose.x_m, slam.trajectory().front().pose.x_m);
  const auto distinct = slam.distinct_ancestors();
  ASSERT_EQ(distinct.size(), slam.records().size());
  EXPECT_EQ(distinct.back(), 10u);
  EXPECT_TRUE(std::is_sorted(distinct.begin(), distinct.end()));
  EXPECT_GT(slam.memory().tile_bytes, 100'000u);
  EXPECT_GE(slam.memory().most_tile_bytes, slam.memory().tile_bytes);
}

TEST(GridSlam, WithoutABeamThereIsNoMap) {
  GridSlam slam(config(SlamProposal::scan_match, 3));
  Scan scan;
  scan.ranges_m.assign(90, 0.0f);
  scan.angle_step_rad = 0.01;
  EXPECT_FALSE(slam.step({0, 0, 0}, scan));
  EXPECT_TRUE(slam.trajectory().empty());
  error_of([&] { (void)slam.map(); }, ErrorKind::input);
}

}  // namespace
}  // namespace parloc
