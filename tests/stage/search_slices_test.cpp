// The global search in slices against itself in one go: the same places, and as much work, however it is
// sliced, on every backend and thread count.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>

#include "common/error.h"
#include "common/map/map_reader.h"
#include "common/search/hypotheses.h"
#include "common/search/lattice_search.h"
#include "common/search/scan_evidence.h"
#include "common/search/search_parts.h"
#include "common/search/search_task.h"
#include "common/simulator/simulator.h"
#include "tests/stage/search_scenes.h"
#include "tests/unit/allocation_count.h"

namespace parloc {
namespace {

using namespace test;

constexpr std::int64_t kWhole = std::numeric_limits<std::int64_t>::max();

ComputeConfig cpu_threads(int threads) {
  return {.backend = BackendChoice::cpu, .threads = threads};
}

/// Everything that a result says, as bits.
std::vector<std::uint64_t> bits_of(const SearchResult& r) {
  std::vector<std::uint64_t> bits{r.hypotheses.size(), r.ambiguous,  r.beams,
                                  r.headings,          r.candidates, r.too_many};
  for (const Hypothesis& h : r.hypotheses) {
    for (const double x : {h.pose.x_m, h.pose.y_m, h.pose.theta_rad, h.score, h.explained, h.through,
                           h.unmapped, h.evidence, h.weight})
      bits.push_back(std::bit_cast<std::uint64_t>(x));
    bits.push_back(h.as_good);
  }
  return bits;
}

struct Sliced {
  SearchResult result;
  std::size_t slices = 0;
  std::int64_t work = 0;
};

Sliced in_slices(GlobalSearch& search, const BeamTable& beams, const SearchPrior& prior, std::int64_t work) {
  Sliced s;
  search.begin(beams, prior);
  for (bool done = false; !done; ++s.slices) {
    EXPECT_TRUE(search.under_way());
    done = search.advance(work);
  }
  EXPECT_FALSE(search.under_way());
  s.result = search.result();
  s.work = search.work_done();
  return s;
}

std::vector<SearchPrior> priors() {
  std::vector<SearchPrior> all(4);
  all[1].region = {{4.0, 3.0, 1.5}};
  all[2].heading = {{3.1, 0.5}};  // beyond the last heading comes the first
  all[3].region = {{4.0, 3.0, 2.5}};
  all[3].heading = {{-0.2, 0.4}};
  return all;
}

TEST(SearchSlices, GiveWhatASearchInOneGoGives) {
  const GridMap map = two_rooms();
  const BeamTable beams = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 3.0));
  GlobalSearch whole(map, small_config(), cpu_threads(1)), one(map, small_config(), cpu_threads(1)),
      two(map, small_config(), cpu_threads(2));
  // What a LiDAR that reaches so far says anywhere is learnt by the first search.
  (void)whole.search(beams);
  EXPECT_EQ(in_slices(one, beams, {}, 12345).work, whole.work_done());
  EXPECT_EQ(in_slices(two, beams, {}, kWhole).work, whole.work_done());
  for (const SearchPrior& prior : priors()) {
    const SearchResult expected = whole.search(beams, prior);
    ASSERT_FALSE(expected.hypotheses.empty());
    for (const std::int64_t work : {std::int64_t{1}, std::int64_t{777}, std::int64_t{100003}, kWhole}) {
      const Sliced a = in_slices(one, beams, prior, work), b = in_slices(two, beams, prior, work);
      EXPECT_EQ(bits_of(a.result), bits_of(expected)) << work;
      EXPECT_EQ(bits_of(b.result), bits_of(expected)) << work;
      EXPECT_EQ(a.slices, b.slices) << work;
      EXPECT_EQ(a.work, whole.work_done()) << work;
      EXPECT_GT(a.slices, work == 1 ? 50u : 0u);
    }
  }
}

/// Champions, sorted, and the work of every slice.
struct Champions {
  std::vector<std::uint64_t> keys;
  std::vector<std::int64_t> slices;
  bool operator==(const Champions&) const = default;
};

Champions champions_in_slices(SearchBackend& backend, const SearchTask& task, const SearchScan& scan,
                              std::int64_t work) {
  Champions c;
  LatticeSearch search;
  search.begin(backend, task, scan, c.keys);
  while (!search.done()) c.slices.push_back(search.advance(work));
  std::sort(c.keys.begin(), c.keys.end());
  return c;
}

std::int64_t sum(const std::vector<std::int64_t>& of) {
  std::int64_t all = 0;
  for (const std::int64_t one : of) all += one;
  return all;
}

TEST(SearchSlices, AreTheSameOnThreadsAndInKernels) {
  for (const bool with_prior : {false, true}) {
    const OneSearch s = one_search(two_rooms(), seen_from(two_rooms(), kSomewhere, 90, 1.2, 3.0), with_prior);
    const auto one = make_cpu_search(s.map, 1), three = make_cpu_search(s.map, 3);
    const auto kernels = cuda_on_host::make_search_on_host(s.map);
    const Champions whole = champions_in_slices(*one, s.task, s.scan, kWhole);
    ASSERT_FALSE(whole.keys.empty());
    EXPECT_EQ(whole.slices.size(), 1u);
    for (const std::int64_t work : {1, 3001, 50000}) {
      const Champions expected = champions_in_slices(*one, s.task, s.scan, work);
      EXPECT_EQ(expected.keys, whole.keys);
      EXPECT_EQ(sum(expected.slices), sum(whole.slices));
      EXPECT_EQ(champions_in_slices(*three, s.task, s.scan, work), expected);
      EXPECT_EQ(champions_in_slices(*kernels, s.task, s.scan, work), expected);
    }
  }
}

// A row of blocks at one heading, or the poses of a block: no slice does more than that beyond what it may.
TEST(SearchSlices, KeepToTheirBudget) {
  const OneSearch s = one_search(two_rooms(), seen_from(two_rooms(), kSomewhere, 90, 1.2, 3.0), false);
  const auto backend = make_cpu_search(s.map, 1);
  const std::int64_t row_of_slots = s.task.block_end_i * kTurnBins / search_work::kSlots;
  const std::int64_t piece =
      std::max(search_work::kBlockBeam * (s.task.beams + search_work::kOtherBeams), row_of_slots);
  for (const std::int64_t work : {1, 500, 20000})
    for (const std::int64_t spent : champions_in_slices(*backend, s.task, s.scan, work).slices) {
      EXPECT_GT(spent, 0);
      EXPECT_LT(spent, work + piece);
    }
}

/// A scan of the office floor, from a drawing finer than its map.
BeamTable office_beams(const GridMap& map, const Pose& pose, double fov_rad) {
  const GridMap fine = read_map("maps/fine/office.yaml");
  Scan scan;
  scan.angle_min_rad = -0.5 * fov_rad;
  scan.angle_step_rad = fov_rad / 90.0;
  scan.range_min_m = 0.05;
  scan.range_max_m = 8.0;
  for (int b = 0; b < 90; ++b) {
    const double angle_rad = pose.theta_rad + scan.angle_min_rad + scan.angle_step_rad * b;
    scan.ranges_m.push_back(
        static_cast<float>(cast_simulated_ray(fine, pose.x_m, pose.y_m, angle_rad, 8.0).range_m));
  }
  return beams_of(map, scan);
}

// So many headings and blocks that the threshold is set anew several times. Were it set by whatever a thread
// happened to have found, then sooner or later more or fewer blocks would be searched.
TEST(SearchSlices, OfSeveralRoundsAreTheSameOnThreadsAndInKernels) {
  const GridMap map = read_map("maps/office.yaml");
  SearchConfig config;
  config.beams = 20;
  config.heading_cells = 0.7;
  const SearchMap searched = make_search_map(map, config);
  SearchScan scan;
  make_search_scan(office_beams(map, {15.0, 5.0, 1.0}, 1.7), map.resolution_m, searched.cell_m, config, scan);
  const SearchTask task = make_search_task(searched, map.T_map_grid, map.name, config, scan, {});
  const auto strips = static_cast<std::size_t>((task.block_end_i + kSweepLanes - 1) / kSweepLanes);
  ASSERT_GT(static_cast<std::size_t>(task.heading_count * task.block_end_j) * strips, 2 * kRoundStrips);
  const auto one = make_cpu_search(searched, 1), two = make_cpu_search(searched, 2);
  const Champions expected = champions_in_slices(*one, task, scan, 300000);
  ASSERT_GT(expected.slices.size(), 10u);
  EXPECT_EQ(champions_in_slices(*two, task, scan, 300000), expected);
  EXPECT_EQ(champions_in_slices(*cuda_on_host::make_search_on_host(searched), task, scan, 300000), expected);
  const Champions whole = champions_in_slices(*two, task, scan, kWhole);
  EXPECT_EQ(whole.keys, expected.keys);
  EXPECT_EQ(sum(whole.slices), sum(expected.slices));
}

TEST(SearchSlices, WhatWasGivenUpLeavesNothingBehind) {
  const GridMap map = two_rooms();
  const BeamTable here = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 3.0));
  const BeamTable there = beams_of(map, seen_from(map, in_rooms(1.2, 3.3, 0.4), 90, 1.7, 3.0));
  GlobalSearch fresh(map, small_config(), cpu_threads(1)), search(map, small_config(), cpu_threads(1));
  const std::vector<std::uint64_t> expected = bits_of(fresh.search(here));
  std::int64_t all = 0;
  for (const std::int64_t part : {1, 20000, 200000, 400000, 700000}) {
    search.begin(there);
    if (search.advance(part)) continue;
    ++all;
    if (part % 3 == 0) {
      search.cancel();
      EXPECT_FALSE(search.under_way());
      EXPECT_TRUE(search.advance(1)) << "there is nothing to do";
      EXPECT_THROW((void)search.result(), Error);
    }
    EXPECT_EQ(bits_of(in_slices(search, here, {}, 50000).result), expected) << part;
  }
  EXPECT_GE(all, 3);
}

// A region's search clears and gathers no more than its blocks: what other searches left elsewhere must not
// count.
TEST(SearchSlices, ARegionIsSearchedAsOnAFreshObject) {
  const GridMap map = two_rooms();
  const BeamTable beams = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 3.0));
  GlobalSearch used(map, small_config(), cpu_threads(1));
  for (const SearchPrior& prior : priors()) {
    (void)used.search(beams);
    GlobalSearch fresh(map, small_config(), cpu_threads(1));
    EXPECT_EQ(bits_of(used.search(beams, prior)), bits_of(fresh.search(beams, prior)));
  }
}

TEST(SearchSlices, ASmallRegionIsLittleWork) {
  const GridMap map = two_rooms();
  const BeamTable beams = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 3.0));
  GlobalSearch search(map, small_config(), cpu_threads(1));
  (void)search.search(beams);
  (void)search.search(beams);
  const std::int64_t whole = search.work_done();
  SearchPrior prior;
  prior.region = {{kSomewhere.x_m, kSomewhere.y_m, 0.5}};
  prior.heading = {{kSomewhere.theta_rad, 0.3}};
  const SearchResult r = search.search(beams, prior);
  ASSERT_FALSE(r.hypotheses.empty());
  EXPECT_FALSE(separated(r.hypotheses[0].pose, kSomewhere, {0.1, 0.05}));
  EXPECT_LT(search.work_done(), whole / 8);
}

TEST(SearchSlices, AllocateNothingOnceGrown) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const GridMap map = two_rooms();
  const BeamTable beams = beams_of(map, seen_from(map, kSomewhere, 90, 1.2, 3.0));
  GlobalSearch search(map, small_config(), cpu_threads(1));
  (void)search.search(beams);
  search.begin(beams);
  const std::size_t before = allocations();
  while (!search.advance(5000)) {
  }
  EXPECT_EQ(allocations(), before);
  search.begin(beams);
  EXPECT_EQ(allocations(), before);
}

TEST(SearchSlices, ThereIsNoResultBeforeTheEnd) {
  const GridMap map = two_rooms();
  GlobalSearch search(map, small_config(), cpu_threads(1));
  EXPECT_FALSE(search.under_way());
  EXPECT_TRUE(search.advance(1000));
  EXPECT_THROW((void)search.result(), Error);
  const BeamTable beams = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 3.0));
  search.begin(beams);
  EXPECT_FALSE(search.advance(1000));
  EXPECT_THROW((void)search.result(), Error);
  (void)SearchParts(search).search_lattice(beams, {}, 5);  // takes its place, and judges nothing
  EXPECT_FALSE(search.under_way());
  EXPECT_THROW((void)search.result(), Error);
  EXPECT_FALSE(in_slices(search, beams, {}, kWhole).result.hypotheses.empty());
  EXPECT_FALSE(search.result().hypotheses.empty()) << "as often as one likes";
}

TEST(SearchSlices, AScanWithoutAHitEndsAtOnce) {
  const GridMap map = two_rooms();
  GlobalSearch search(map, small_config(), cpu_threads(1));
  const Sliced s = in_slices(search, BeamTable{}, {}, 1);
  EXPECT_TRUE(s.result.hypotheses.empty());
  EXPECT_LE(s.slices, 3u);
}

TEST(SearchSlices, ARegionWithoutAFreeCellBeginsNothing) {
  const GridMap map = two_rooms();
  const BeamTable beams = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 3.0));
  GlobalSearch search(map, small_config(), cpu_threads(1));
  search.begin(beams);
  SearchPrior nowhere;
  nowhere.region = {{-1.0 + 10 * 0.05, 2.0 + 16.5 * 0.05, 0.01}};  // among the unknown cells
  try {
    search.begin(beams, nowhere);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::input);
    EXPECT_NE(std::string(e.what()).find("the search region has no free cell"), std::string::npos)
        << e.what();
  }
  EXPECT_FALSE(search.under_way());
}

TEST(ScanEvidenceSlices, WhatIsLearntInPiecesIsTheSame) {
  const GridMap map = two_rooms();
  const BeamTable beams = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 3.0));
  const BeamTable other = beams_of(map, seen_from(map, kSomewhere, 90, 2 * kPi, 5.0));
  const Pose in_grid = relative(kSomewhere, map.T_map_grid);
  ScanEvidence once(map), pieces(map);
  EXPECT_EQ(pieces.learn(other.range_max_m, 100), 1948u);  // given up for another reach
  EXPECT_EQ(pieces.learn(beams.range_max_m, 0), 2048u);
  for (std::size_t left = 2048; left > 0;) {
    const std::size_t before = left;
    left = pieces.learn(beams.range_max_m, 300);
    EXPECT_EQ(before - left, std::min<std::size_t>(300, before));
  }
  EXPECT_EQ(pieces.per_beam(beams, in_grid), once.per_beam(beams, in_grid));
  EXPECT_EQ(pieces.per_beam(other, in_grid), once.per_beam(other, in_grid));
}

}  // namespace
}  // namespace parloc
