// Places larger than memory: far places are handed over and given back, and the map is nearly the one that
// comes of as much memory as one likes.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/eval/metrics.h"
#include "common/math/portable64.h"
#include "common/slam/grid_slam.h"
#include "tests/unit/ring_drive.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

constexpr double kRadius_m = 25.0;

/// With posts at uneven distances.
const test::Ring& ring() {
  static const test::Ring made(kRadius_m, [](int along) { return along % 16 < 3 || along % 23 < 2; });
  return made;
}

/// Once around and 20 m more; the odometry is 0.2 % short and turns too far, then too little.
const test::RingDrive& drive() {
  static const test::RingDrive d = drive_along(
      ring(), 2.0 * kPi * kRadius_m + 20.0,
      [](int k, Pose step) {
        step.x_m *= 0.998, step.theta_rad += k % 2 == 0 ? 0.001 : -0.001;
        return step;
      },
      [](double range_m) { return range_m; });
  return d;
}

GridSlamConfig config(int memory_mib, int threads = 1) {
  GridSlamConfig c;
  c.backend = BackendChoice::cpu;
  c.threads = threads;
  c.slam.particles = 8;
  c.scan.max_beams = 90;
  c.slam.usable_range = 7.0;
  c.slam.memory_mib = memory_mib;
  c.slam.close_loops = false;  // the maps of the particles are looked at
  c.motion.alpha1 = c.motion.alpha2 = c.motion.alpha3 = c.motion.alpha4 =
      0.03;  // good wheels: the loop closes
  c.slam.motion_floor_xy = 0.003, c.slam.motion_floor_theta = 0.001;
  return c;
}

const GridSlam& without_limit() {
  static const auto slam = mapped(config(0), drive());
  return *slam;
}

/// Share of the cells that both know, in a common frame, that are the same; and how many these are.
struct Agreement {
  double same;
  std::size_t both, known;
};
Agreement agreement(const GridMap& a, const GridMap& b) {
  Agreement g{0, 0, 0};
  const auto di =
      static_cast<std::int32_t>(std::lround((a.T_map_grid.x_m - b.T_map_grid.x_m) / a.resolution_m));
  const auto dj =
      static_cast<std::int32_t>(std::lround((a.T_map_grid.y_m - b.T_map_grid.y_m) / a.resolution_m));
  std::size_t same = 0;
  for (std::int32_t j = 0; j < a.height; ++j)
    for (std::int32_t i = 0; i < a.width; ++i) {
      const bool inside = i + di >= 0 && j + dj >= 0 && i + di < b.width && j + dj < b.height;
      const Cell there = inside ? b.at(i + di, j + dj) : Cell::unknown;
      g.known += a.at(i, j) != Cell::unknown ? 1 : 0;
      if (a.at(i, j) == Cell::unknown || there == Cell::unknown) continue;
      ++g.both;
      same += a.at(i, j) == there ? 1 : 0;
    }
  g.same = static_cast<double>(same) / static_cast<double>(g.both);
  return g;
}

std::size_t most_handed_over(const GridSlam& slam) {
  std::size_t most = 0;
  for (const SlamRecord& r : slam.records()) most = std::max(most, r.handed_over);
  return most;
}

constexpr int kTight_mib = 10;

TEST(SubMaps, ATightLimitIsKeptAndTheMapIsNearlyTheSame) {
  constexpr std::size_t kTight = std::size_t{kTight_mib} << 20;
  const auto tight = mapped(config(kTight_mib), drive());
  const GridSlam& whole = without_limit();
  ASSERT_GT(whole.memory().most_tile_bytes, kTight + kTight / 4);
  EXPECT_LE(tight->memory().most_tile_bytes, kTight);
  EXPECT_GT(most_handed_over(*tight), 20u);
  // The loop is closed: what was handed over at its beginning is in use again.
  const auto& records = tight->records();
  bool given_back = false;
  for (std::size_t k = 1; k < records.size(); ++k)
    given_back |= records[k].handed_over < records[k - 1].handed_over;
  EXPECT_TRUE(given_back);
  const double off_m = compare_tracks(tight->trajectory(), drive().truth).position_rmse_m;
  const double whole_off_m = compare_tracks(whole.trajectory(), drive().truth).position_rmse_m;
  const Agreement g = agreement(tight->map(), whole.map());
  // Seen: 0.314 m off with and without a limit; 99.9 % of the known cells are known to both, 99.6 % the same.
  EXPECT_LT(off_m, whole_off_m + 0.02);
  EXPECT_GT(g.same, 0.98);
  EXPECT_GT(static_cast<double>(g.both), 0.99 * static_cast<double>(g.known));
}

TEST(SubMaps, AnAmpleLimitChangesNothing) {
  const auto ample = mapped(config(1000), drive());
  EXPECT_EQ(ample->digest(), without_limit().digest());
  EXPECT_EQ(most_handed_over(*ample), 0u);
}

TEST(SubMaps, ThreadsDoNotMatterAndABreakLeavesNoTrace) {
  const auto one = mapped(config(kTight_mib), drive());
  GridSlam three(config(kTight_mib, 3));
  run(three, drive(), 0, 300);
  const test::TempFile file("checkpoint");
  three.save(file.path());
  GridSlam again{SlamCheckpoint(file.path())};
  run(again, drive(), 300, drive().scans.size());
  EXPECT_GT(three.records().back().handed_over, 0u);
  EXPECT_EQ(again.digest(), one->digest());
  EXPECT_EQ(again.memory().sub_map_bytes, one->memory().sub_map_bytes);
}

TEST(SubMaps, TooLittleForWhatIsNearIsToldAtOnce) {
  expect_parts(error_of([] { mapped(config(1), drive()); }, ErrorKind::config),
               {"slam.memory_mib is 1, but what is near the robot takes"});
}

}  // namespace
}  // namespace parloc
