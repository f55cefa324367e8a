// The global search against a search through every pose, and against itself on other backends, thread counts
// and instruction sets: identical poses and scores.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "common/math/portable64.h"
#include "common/model/beams.h"
#include "common/search/global_search.h"
#include "common/search/hypotheses.h"
#include "common/search/search_backend.h"
#include "common/search/search_parts.h"
#include "tests/stage/search_scenes.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/without_gpu.h"

namespace parloc {
namespace {

using namespace test;

/// The definition, word for word: every pose of the lattice; the best of each block and heading bin; greedily
/// those apart.
std::vector<LatticePose> brute_force(GlobalSearch& search, const SearchConfig& config, std::size_t most) {
  const SearchGrid grid = SearchParts(search).map().view();
  const SearchScan& scan = SearchParts(search).scan();
  struct Champion {
    LatticePose pose;
    bool there = false;
  };
  std::vector<Champion> champions(static_cast<std::size_t>(grid.blocks_x() * grid.blocks_y() * 36));
  std::uint32_t best = 0;
  for (std::int32_t k = 0; k < scan.headings; ++k)
    for (std::int32_t j = 0; j < grid.height; ++j)
      for (std::int32_t i = 0; i < grid.width; ++i) {
        if (!grid.is_free(i, j)) continue;
        std::uint32_t score = 0;
        for (std::int32_t b = 0; b < scan.beams; ++b) {
          const Offset o = scan.offsets[static_cast<std::size_t>(k * scan.beams + b)];
          const std::int32_t x = i + o.x, y = j + o.y;
          if (x >= 0 && y >= 0 && x < grid.width && y < grid.height)
            score += grid.cells.first[y * grid.cells.stride + x];
        }
        best = std::max(best, score);
        Champion& c = champions[static_cast<std::size_t>(((j / 8) * grid.blocks_x() + i / 8) * 36 +
                                                         k * 36 / scan.headings)];
        if (!c.there || score > c.pose.score) c = {{i, j, k, score}, true};
      }
  const double full = 63.0 * scan.beams;
  std::vector<LatticePose> poses;
  for (const Champion& c : champions)
    if (c.there && c.pose.score >= std::floor(config.least_score * full) &&
        c.pose.score * 1024 >= best * std::floor(config.least_share * 1024))
      poses.push_back(c.pose);
  std::sort(poses.begin(), poses.end(), [](const LatticePose& a, const LatticePose& b) {
    return std::make_tuple(b.score, a.k, a.j, a.i) < std::make_tuple(a.score, b.k, b.j, b.i);
  });
  std::vector<LatticePose> taken;
  for (const LatticePose& p : poses) {
    bool apart = taken.size() < most;
    for (const LatticePose& q : taken) {
      const double d = std::hypot(p.i - q.i, p.j - q.j) * SearchParts(search).map().cell_m;
      const double turn = std::fabs(wrap64(2 * kPi * (p.k - q.k) / scan.headings));
      apart = apart && (d >= config.separation_m || turn >= config.separation_rad);
    }
    if (apart) taken.push_back(p);
  }
  return taken;
}

void expect_same(const std::vector<LatticePose>& a, const std::vector<LatticePose>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    EXPECT_EQ(a[n].i, b[n].i) << n;
    EXPECT_EQ(a[n].j, b[n].j) << n;
    EXPECT_EQ(a[n].k, b[n].k) << n;
    EXPECT_EQ(a[n].score, b[n].score) << n;
  }
}

TEST(GlobalSearch, FindsWhatASearchThroughEveryPoseFinds) {
  const GridMap map = two_rooms();
  const SearchConfig config = small_config();
  GlobalSearch search(map, config, kOnCpu);
  const Pose places[] = {in_rooms(1.2, 3.3, 0.4), in_rooms(5.1, 0.9, -2.2), in_rooms(3.4, 0.8, 3.0)};
  for (const Pose& place : places)
    for (const double fov_rad : {2 * kPi, 1.7}) {
      const Scan scan = seen_from(map, place, 90, fov_rad, 3.0);
      const std::vector<LatticePose> found = SearchParts(search).search_lattice(beams_of(map, scan), {}, 30);
      ASSERT_GE(found.size(), 2u);  // else there is little to compare
      expect_same(found, brute_force(search, config, 30));
    }
}

TEST(GlobalSearch, ABoundIsNeverBelowAScoreOfItsBlock) {
  const GridMap map = two_rooms();
  GlobalSearch search(map, small_config(), kOnCpu);
  // Far beams: most windows lie partly or wholly off the map.
  Scan scan = seen_from(map, in_rooms(5.1, 0.9, -2.2), 90, 2 * kPi, 20.0);
  for (std::size_t b = 0; b < scan.ranges_m.size(); b += 3) scan.ranges_m[b] *= 2.5f;
  (void)SearchParts(search).search_lattice(beams_of(map, scan), {}, 1);
  SearchTask task;
  task.grid = SearchParts(search).map().view();
  task.offsets = SearchParts(search).scan().offsets.data();
  task.beams = SearchParts(search).scan().beams;
  task.headings = SearchParts(search).scan().headings;
  std::mt19937 random(5);
  const auto below = [&](std::int32_t n) {
    return static_cast<std::int32_t>(random() % static_cast<unsigned>(n));
  };
  std::size_t tight = 0;
  for (int n = 0; n < 20000; ++n) {
    const std::int32_t k = below(task.headings), i = below(task.grid.width), j = below(task.grid.height);
    const std::uint32_t bound = bound_of_block(task, k, i / 8, j / 8, 0);
    const std::uint32_t score = score_of_pose(task, k, i, j, 0);
    ASSERT_GE(bound, score) << k << " " << i << " " << j;
    tight += bound < score + 63 * static_cast<std::uint32_t>(task.beams) / 4 ? 1 : 0;
  }
  EXPECT_GT(tight, 1000u);  // a bound that is always the most there can be would pass, too
}

/// The champions of a backend, sorted.
std::vector<std::uint64_t> champions_of(SearchBackend& backend, const SearchTask& task,
                                        const SearchScan& scan) {
  std::vector<std::uint64_t> keys;
  backend.search(task, scan, keys);
  std::sort(keys.begin(), keys.end());
  return keys;
}

TEST(GlobalSearchBackends, KernelBodiesThreadsAndInstructionSetsAgree) {
  for (const bool with_prior : {false, true})
    for (const double fov_rad : {2 * kPi, 1.2}) {
      const OneSearch s =
          one_search(two_rooms(), seen_from(two_rooms(), kSomewhere, 90, fov_rad, 3.0), with_prior);
      const auto one = make_cpu_search(s.map, 1);
      const std::vector<std::uint64_t> expected = champions_of(*one, s.task, s.scan);
      ASSERT_FALSE(expected.empty());
      EXPECT_EQ(champions_of(*one, s.task, s.scan), expected) << "the same object again";
      for (const int threads : {2, 4, 7})
        EXPECT_EQ(champions_of(*make_cpu_search(s.map, threads), s.task, s.scan), expected) << threads;
      const auto kernels = cuda_on_host::make_search_on_host(s.map);
      EXPECT_EQ(champions_of(*kernels, s.task, s.scan), expected) << "kernels on the host";
      EXPECT_EQ(champions_of(*kernels, s.task, s.scan), expected) << "and again";
      for (const cpu::Simd level : {cpu::Simd::avx2, cpu::Simd::baseline}) {
        const test::SimdLimit limit(level);
        EXPECT_EQ(champions_of(*one, s.task, s.scan), expected) << cpu::simd_name(level);
      }
    }
}

TEST(GlobalSearchBackends, GpuEqualsCpu) {
  const ComputeConfig on_gpu{.backend = BackendChoice::cuda};
  std::unique_ptr<GlobalSearch> gpu;
  PARLOC_NEEDS_GPU(gpu = std::make_unique<GlobalSearch>(two_rooms(), small_config(), on_gpu));
  GlobalSearch cpu(two_rooms(), small_config(), kOnCpu);
  for (const double fov_rad : {2 * kPi, 1.2}) {
    const BeamTable beams = beams_of(two_rooms(), seen_from(two_rooms(), kSomewhere, 90, fov_rad, 3.0));
    expect_same(SearchParts(*gpu).search_lattice(beams, {}, 30),
                SearchParts(cpu).search_lattice(beams, {}, 30));
  }
}

}  // namespace
}  // namespace parloc
