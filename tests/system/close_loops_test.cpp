// Loops closed after the fact: a round that one particle leaves open is closed by slam.close_loops, to the
// same bits at any number of threads and with a break.
#include "common/slam/loops/close_loops.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/math/portable64.h"
#include "common/slam/grid_slam.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/ring_drive.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

using test::Ring, test::RingDrive;

constexpr double kRadius_m = 20.0, kRound_m = 2.0 * kPi * kRadius_m;

enum class Posts { uneven, even, none };

Ring made_ring(double radius_m, Posts posts) {
  return Ring(radius_m, [posts](int along) {
    return posts != Posts::none && (along % 37 < 3 || (posts == Posts::uneven && along % 53 < 2));
  });
}
const Ring& ring() {
  static const Ring made = made_ring(kRadius_m, Posts::uneven);
  return made;
}

/// Once around and 15 m more, where the robot sees again what it saw.
const RingDrive& round_and_more() {
  static const RingDrive d = noisy_drive_along(ring(), kRound_m + 15.0);
  return d;
}
/// The same on a smaller ring, for bits.
const RingDrive& small_round() {
  constexpr double kSmall_m = 8.0;
  static const RingDrive d =
      noisy_drive_along(made_ring(kSmall_m, Posts::uneven), 2.0 * kPi * kSmall_m + 15.0);
  return d;
}

GridSlamConfig config(bool close, int threads = 1) {
  GridSlamConfig c;
  c.backend = BackendChoice::cpu;
  c.threads = threads;
  c.slam.particles = 1;
  c.scan.max_beams = 90;
  c.slam.usable_range = 7.0;
  c.slam.close_loops = close;
  return c;
}

const GridSlam& made(bool close) {
  static const auto open = mapped(config(false), round_and_more());
  static const auto closed = mapped(config(true), round_and_more());
  return close ? *closed : *open;
}

/// Where the robot comes by the second time, seen from the first time, and where it should be.
double step_at_the_loop_m(const Trajectory& path, const Trajectory& truth) {
  double most_m = 0.0;
  for (std::size_t k = static_cast<std::size_t>(kRound_m / RingDrive::kStep_m) + 1; k < path.size(); ++k) {
    const std::size_t before = k - static_cast<std::size_t>(std::lround(kRound_m / RingDrive::kStep_m));
    const Pose seen = relative(path[k].pose, path[before].pose);
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
    const GridMap& truth = ring().map();
    return i >= 0 && j >= 0 && i < truth.width && j < truth.height &&
           truth.cells[static_cast<std::size_t>(j * truth.width + i)] == Cell::occupied;
  };
  std::size_t count = 0;
  for (int j = 0, k = 0; j < map.height; ++j)
    for (int i = 0; i < map.width; ++i, ++k) {
      if (map.cells[static_cast<std::size_t>(k)] != Cell::occupied) continue;
      const Pose cell{(i + 0.5) * map.resolution_m, (j + 0.5) * map.resolution_m, 0.0};
      const Pose at = compose(ring().at(0.0), compose(map.T_map_grid, cell));
      const int u = static_cast<int>(std::floor(at.x_m / 0.1)),
                v = static_cast<int>(std::floor(at.y_m / 0.1));
      bool near = false;
      for (int d = 0; d < 25 && !near; ++d) near = is_wall(u + d % 5 - 2, v + d / 5 - 2);
      count += near ? 0 : 1;
    }
  return count;
}

TEST(CloseLoops, TheMapIsDrawnAnewAlongTheClosedPath) {
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
  const RingDrive half = noisy_drive_along(ring(), 0.5 * kRound_m);
  const auto closed = mapped(config(true), half);
  EXPECT_EQ(closed->digest(), mapped(config(false), half)->digest());
  EXPECT_EQ(closed->loops().value().used, 0u);
  EXPECT_EQ(closed->loops().value().most_moved_m, 0.0);
}

// Posts that repeat exactly fit as well a period on; without posts all places look the same. A loop that is
// closed there at the wrong place would do more harm than one left open.
TEST(CloseLoops, WhatRepeatsDoesNoHarm) {
  for (const Posts posts : {Posts::even, Posts::none}) {
    SCOPED_TRACE(static_cast<int>(posts));
    const RingDrive d = noisy_drive_along(made_ring(kRadius_m, posts), kRound_m + 15.0);
    const auto slam = mapped(config(true), d);
    const TrackErrors open = compare_tracks(slam->trajectory_so_far(), d.truth);
    const TrackErrors closed = compare_tracks(slam->trajectory(), d.truth);
    RecordProperty("open_m", std::to_string(open.position_rmse_m));
    RecordProperty("closed_m", std::to_string(closed.position_rmse_m));
    EXPECT_LE(closed.position_rmse_m, 1.05 * open.position_rmse_m);
  }
}

/// Of the small round, and that loops were closed in it.
std::string bits_of(const GridSlam& slam) {
  EXPECT_GT(slam.loops().value().used, 0u);
  return slam.digest();
}
const std::string& small_bits() {
  static const std::string bits = bits_of(*mapped(config(true), small_round()));
  return bits;
}

TEST(CloseLoops, SameBitsWithAnyInstructionSet) {
  for (const cpu::Simd set : test::instruction_sets()) {
    const test::SimdLimit limit(set);
    EXPECT_EQ(bits_of(*mapped(config(true), small_round())), small_bits());
  }
}

TEST(CloseLoops, SameBitsAtAnyNumberOfThreads) {
  EXPECT_EQ(bits_of(*mapped(config(true, 3), small_round())), small_bits());
}

TEST(CloseLoops, SameBitsAfterABreak) {
  const RingDrive& d = small_round();
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
  EXPECT_EQ(bits_of(slam), small_bits());
}

TEST(CloseLoops, NothingOfNothing) {
  GridSlam slam(config(true));
  EXPECT_TRUE(slam.trajectory().empty());
  EXPECT_EQ(slam.loops().value().tried, 0u);
  EXPECT_THROW(slam.map(), Error);
  EXPECT_TRUE(close_loops({}, *make_cpu_scan_matcher({}), {}).path.empty());
}

// A fine map needs smaller windows of search than a coarse one.
TEST(CloseLoops, FineMapsAreSearched) {
  GridSlamConfig c = config(true);
  c.slam.resolution = 0.02;
  GridSlam slam(c);
  run(slam, round_and_more(), 0, 40);
  EXPECT_EQ(slam.trajectory().size(), 40u);
}

}  // namespace
}  // namespace parloc
