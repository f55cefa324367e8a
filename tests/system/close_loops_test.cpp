// Loops closed after the fact: a round that one particle leaves open is closed by slam.close_loops, to the
// same bits at any number of threads and with a break.
#include "common/slam/close_loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/eval/simulator.h"
#include "common/math/portable64.h"
#include "common/slam/grid_slam.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/simulated.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

constexpr double kRadius_m = 20.0, kRound_m = 2.0 * kPi * kRadius_m, kMiddle_m = 22.0;

enum class Posts { uneven, even, none };

/// A round corridor, 2 m wide, with posts; cells of 10 cm.
const GridMap& ring(Posts posts = Posts::uneven) {
  static const auto made = [](Posts which) {
    constexpr int kSize = 440;
    std::vector<std::string> rows(kSize, std::string(kSize, '.'));
    for (int j = 0; j < kSize; ++j)
      for (int i = 0; i < kSize; ++i) {
        const double x_m = (i + 0.5) * 0.1 - kMiddle_m, y_m = (j + 0.5) * 0.1 - kMiddle_m;
        const double to_wall_m = 1.0 - std::fabs(std::hypot(x_m, y_m) - kRadius_m);
        const int along = static_cast<int>((std::atan2(y_m, x_m) + kPi) * kRadius_m / 0.1);
        const bool post =
            which != Posts::none && (along % 37 < 3 || (which == Posts::uneven && along % 53 < 2));
        const double deep_m = post ? 0.35 : 0.0;
        if (to_wall_m < deep_m && to_wall_m > -0.2)
          rows[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] = '#';
      }
    return grid_from_text(rows, 0.1);
  };
  static const GridMap maps[] = {made(Posts::uneven), made(Posts::even), made(Posts::none)};
  return maps[static_cast<std::size_t>(posts)];
}

/// Along the middle of the corridor, counter-clockwise.
Pose on_ring(double way_m) {
  const double angle = way_m / kRadius_m;
  return {kMiddle_m + kRadius_m * std::cos(angle), kMiddle_m + kRadius_m * std::sin(angle),
          wrap64(angle + kPi / 2)};
}

struct Drive {
  std::vector<Pose> odometry;
  std::vector<Scan> scans;
  Trajectory truth;  ///< From the first scan.
};

/// A scan every 0.3 m. Ranges are off by 3 cm, steps of the odometry by a hundredth and 0.2 degrees.
Drive drive(double way_m, Posts posts = Posts::uneven) {
  Drive out;
  std::mt19937 random(7);
  const auto noise = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
  Pose odometry;
  for (int k = 0; 0.3 * k < way_m; ++k) {
    const Pose pose = on_ring(0.3 * k);
    if (k > 0) {
      Pose step = relative(pose, on_ring(0.3 * (k - 1)));
      step.x_m *= 0.99, step.theta_rad += 0.0035 * noise();
      odometry = compose(odometry, step);
    }
    Scan scan;
    scan.stamp_s = 10.0 + 0.3 * k;
    scan.angle_min_rad = -kPi;
    scan.angle_step_rad = kPi / 45;
    scan.range_max_m = 8.0;
    for (int i = 0; i < 90; ++i) {
      const double angle_rad = pose.theta_rad + scan.angle_min_rad + i * kPi / 45;
      const double range_m = cast_simulated_ray(ring(posts), pose.x_m, pose.y_m, angle_rad, 8.0).range_m;
      scan.ranges_m.push_back(static_cast<float>(range_m < 7.9 ? range_m + 0.03 * noise() : range_m));
    }
    out.odometry.push_back(odometry);
    out.scans.push_back(scan);
    out.truth.push_back({scan.stamp_s, relative(pose, on_ring(0.0))});
  }
  return out;
}
/// Once around and 15 m more, where the robot sees again what it saw.
const Drive& round_and_more() {
  static const Drive d = drive(kRound_m + 15.0);
  return d;
}

FilterConfig config(bool close, int threads = 1) {
  FilterConfig c;
  c.backend = BackendChoice::cpu;
  c.threads = threads;
  c.slam.particles = 1;
  c.slam.max_beams = 90;
  c.slam.usable_range = 7.0;
  c.slam.close_loops = close;
  return c;
}

void run(GridSlam& slam, const Drive& d, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) slam.step(d.odometry[k], d.scans[k]);
}
const GridSlam& made(bool close) {
  static const auto make = [](bool with) {
    auto* slam = new GridSlam(config(with));
    run(*slam, round_and_more(), 0, round_and_more().scans.size());
    return slam;
  };
  static const GridSlam* const open = make(false);
  static const GridSlam* const closed = make(true);
  return close ? *closed : *open;
}

/// Where the robot comes by the second time, seen from the first time, and where it should be.
double step_at_the_loop_m(const Trajectory& way, const Trajectory& truth) {
  double most_m = 0.0;
  for (std::size_t k = static_cast<std::size_t>(kRound_m / 0.3) + 1; k < way.size(); ++k) {
    const std::size_t before = k - static_cast<std::size_t>(std::lround(kRound_m / 0.3));
    const Pose seen = relative(way[k].pose, way[before].pose);
    const Pose is = relative(truth[k].pose, truth[before].pose);
    most_m = std::max(most_m, std::hypot(seen.x_m - is.x_m, seen.y_m - is.y_m));
  }
  return most_m;
}

TEST(CloseLoops, ARoundThatOneParticleLeavesOpenIsClosed) {
  const Trajectory& truth = round_and_more().truth;
  const double open_m = step_at_the_loop_m(made(false).trajectory(), truth);
  const double closed_m = step_at_the_loop_m(made(true).trajectory(), truth);
  RecordProperty("open_m", std::to_string(open_m));
  RecordProperty("closed_m", std::to_string(closed_m));
  ASSERT_GT(open_m, 0.3);
  EXPECT_LT(closed_m, 0.1);  // two cells of its map
  const TrackErrors open = compare_tracks(made(false).trajectory(), truth);
  const TrackErrors closed = compare_tracks(made(true).trajectory(), truth);
  EXPECT_LT(closed.position_rmse_m, 0.5 * open.position_rmse_m);
  const LoopCounts counts = made(true).loops().value();
  EXPECT_GE(counts.used, 3u);
  EXPECT_GE(counts.found, counts.used);
  EXPECT_GE(counts.tried, counts.found);
  EXPECT_GT(counts.most_moved_m, 0.1);
}

/// Walls of a map that are farther than 0.2 m, two cells of the truth, from any true wall.
std::size_t false_walls(const GridMap& map) {
  const auto is_wall = [](int i, int j) {
    const GridMap& truth = ring();
    return i >= 0 && j >= 0 && i < truth.width && j < truth.height &&
           truth.cells[static_cast<std::size_t>(j * truth.width + i)] == Cell::occupied;
  };
  std::size_t count = 0;
  for (int j = 0, k = 0; j < map.height; ++j)
    for (int i = 0; i < map.width; ++i, ++k) {
      if (map.cells[static_cast<std::size_t>(k)] != Cell::occupied) continue;
      const Pose cell{(i + 0.5) * map.resolution_m, (j + 0.5) * map.resolution_m, 0.0};
      const Pose at = compose(on_ring(0.0), compose(map.T_map_grid, cell));
      const int u = static_cast<int>(std::floor(at.x_m / 0.1)),
                v = static_cast<int>(std::floor(at.y_m / 0.1));
      bool near = false;
      for (int d = 0; d < 25 && !near; ++d) near = is_wall(u + d % 5 - 2, v + d / 5 - 2);
      count += near ? 0 : 1;
    }
  return count;
}

TEST(CloseLoops, TheMapIsDrawnAnewAlongTheClosedWay) {
  const std::size_t open = false_walls(made(false).map()), closed = false_walls(made(true).map());
  RecordProperty("open_cells", std::to_string(open));
  RecordProperty("closed_cells", std::to_string(closed));
  ASSERT_GT(open, 500u);
  EXPECT_LT(closed, open / 2);
}

TEST(CloseLoops, WhatTheParticleHasIsLeftAsItIs) {
  EXPECT_EQ(made(true).map_so_far().cells, made(false).map().cells);
  const Trajectory a = made(true).trajectory_so_far(), b = made(false).trajectory();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].pose.x_m, b[k].pose.x_m);
  EXPECT_FALSE(made(false).loops().has_value());
  EXPECT_NE(made(true).digest(), made(false).digest());
}

TEST(CloseLoops, WithoutALoopNothingIsMoved) {
  const Drive half = drive(0.5 * kRound_m);
  GridSlam open(config(false)), closed(config(true));
  run(open, half, 0, half.scans.size());
  run(closed, half, 0, half.scans.size());
  EXPECT_EQ(closed.digest(), open.digest());
  EXPECT_EQ(closed.loops().value().used, 0u);
  EXPECT_EQ(closed.loops().value().most_moved_m, 0.0);
}

// Posts that repeat exactly fit as well a period on; without posts all places look the same. A loop that is
// closed there at the wrong place would do more harm than one left open.
TEST(CloseLoops, WhatRepeatsDoesNoHarm) {
  for (const Posts posts : {Posts::even, Posts::none}) {
    SCOPED_TRACE(static_cast<int>(posts));
    const Drive d = drive(kRound_m + 15.0, posts);
    GridSlam slam(config(true));
    run(slam, d, 0, d.scans.size());
    const TrackErrors open = compare_tracks(slam.trajectory_so_far(), d.truth);
    const TrackErrors closed = compare_tracks(slam.trajectory(), d.truth);
    RecordProperty("open_m", std::to_string(open.position_rmse_m));
    RecordProperty("closed_m", std::to_string(closed.position_rmse_m));
    EXPECT_LE(closed.position_rmse_m, 1.05 * open.position_rmse_m);
  }
}

TEST(CloseLoops, SameBitsWithAnyInstructionSet) {
  for (const cpu::Simd set : test::instruction_sets()) {
    const test::SimdLimit limit(set);
    GridSlam slam(config(true));
    run(slam, round_and_more(), 0, round_and_more().scans.size());
    EXPECT_EQ(slam.digest(), made(true).digest());
  }
}

TEST(CloseLoops, SameBitsAtAnyNumberOfThreads) {
  GridSlam slam(config(true, 3));
  run(slam, round_and_more(), 0, round_and_more().scans.size());
  EXPECT_EQ(slam.digest(), made(true).digest());
}

TEST(CloseLoops, SameBitsAfterABreak) {
  const Drive& d = round_and_more();
  const std::size_t half = d.scans.size() / 2;
  const test::TempFile file("loops.checkpoint");
  {
    GridSlam slam(config(true));
    run(slam, d, 0, half);
    (void)slam.trajectory();  // what was computed for it must leave no trace
    slam.save(file.path());
  }
  GridSlam slam{SlamCheckpoint(file.path())};
  run(slam, d, half, d.scans.size());
  EXPECT_EQ(slam.digest(), made(true).digest());
}

TEST(CloseLoops, NothingOfNothing) {
  GridSlam slam(config(true));
  EXPECT_TRUE(slam.trajectory().empty());
  EXPECT_EQ(slam.loops().value().tried, 0u);
  EXPECT_THROW(slam.map(), Error);
  EXPECT_TRUE(close_loops({}, {}, 1).path.empty());
}

// A fine map needs smaller windows of search than a coarse one.
TEST(CloseLoops, FineMapsAreSearched) {
  FilterConfig c = config(true);
  c.slam.resolution = 0.02;
  GridSlam slam(c);
  run(slam, round_and_more(), 0, 40);
  EXPECT_EQ(slam.trajectory().size(), 40u);
}

}  // namespace
}  // namespace parloc
