// Scans drawn into maps and matched to them: the kernel bodies run on the host, the OpenMP loops at several
// thread counts and instruction sets, and a GPU where there is one, must agree to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <numeric>

#include "common/error.h"
#include "common/slam/slam_backend.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/stage/room_scan.h"
#include "tests/stage/same_bits.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/without_gpu.h"

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<ScanMatcher> make_scan_matcher_on_host(const ScanMatcherConfig& config);
}
namespace {

constexpr std::size_t kMaps = 3;

ScanMatcherConfig config(int threads) {
  SlamConfig c;
  c.usable_range = 4.0;  // some beams are cut
  c.clear_range = 3.0;   // what saw nothing is drawn, too
  return {bind_matcher_rules(c), threads, 0};
}

/// Scans from poses in the room, which are its map's frame.
class Scans {
 public:
  const BeamTable* from(const Pose& pose, int most_beams) {
    ScanConfig scan_config;
    scan_config.max_beams = most_beams;
    BeamCounts counts;
    select_beams(test::scan_with_gaps(room_, pose, 900, 6.0), scan_config, SensorConfig{}, 0.05,
                 tables_.emplace_back(), counts);
    return &tables_.back();
  }
  Pose at(double x_m, double y_m, double theta_rad) const {
    return compose(room_.T_map_grid, {x_m, y_m, theta_rad});
  }

 private:
  GridMap room_ = test::room_of_blocks(test::rows_with_blocks_and_wall());
  std::deque<BeamTable> tables_;
};

struct Trace {
  std::vector<ScanMatch> matches;
  std::vector<SlamCells> cells;  ///< By map.
};

/// Of each map some scans more than of the one before, all in turns.
std::vector<ScanDrawing> drawings(Scans& scans, const Pose& origin) {
  std::vector<ScanDrawing> out;
  for (std::size_t round = 0; round < 2 * kMaps; ++round)
    for (std::size_t map = round / 2; map < kMaps; ++map) {
      const Pose truth =
          scans.at(0.8 + 0.1 * static_cast<double>(round), 1.5, 0.1 * static_cast<double>(map));
      out.push_back({map, scans.from(truth, 60 + 40 * static_cast<int>(round)), relative(truth, origin)});
    }
  return out;
}

/// Climbs, searches, and how well scans fit where they start, against all maps and one that is empty.
std::vector<ScanQuery> queries(Scans& scans, const ScanMatcher& matcher) {
  std::vector<ScanQuery> out;
  for (std::size_t k = 0; k < 24; ++k) {
    const double off = 0.02 * static_cast<double>(k % 7);
    const Pose truth = scans.at(1.0 + 0.03 * static_cast<double>(k), 1.6, 0.2);
    const Pose start = compose(truth, {off, -off, off});
    const double pull = k % 2 == 0 ? 0.0 : 2.0;
    const ClimbRules climb{0.05f, 0.05f, 7, static_cast<float>(pull)};
    const SearchRules search = bind_search_rules(matcher.rules().resolution_m, 0.55, 0.1, 0.05);
    out.push_back({k % (kMaps + 1), scans.from(truth, 100 + static_cast<int>(k)), start,
                   k % 3 == 0 ? ClimbRules{} : climb, k % 5 == 2 ? search : SearchRules{}});
  }
  return out;
}

Trace run(ScanMatcher& matcher) {
  Scans scans;
  Trace t;
  const auto match = [&] {
    for (const ScanMatch& m : matcher.match(queries(scans, matcher))) t.matches.push_back(m);
  };
  match();  // nothing is drawn yet
  matcher.draw(drawings(scans, {}));
  match();
  matcher.draw(drawings(scans, {-9.0, 20.0, 1.0}));  // far from there: the tables grow
  match();
  for (std::size_t map = 0; map < kMaps; ++map) t.cells.push_back(matcher.cells(map));
  matcher.clear();
  match();
  matcher.draw(drawings(scans, {}));
  match();
  t.cells.push_back(matcher.cells(1));
  return t;
}

void expect_same(const Trace& a, const Trace& b) {
  ASSERT_EQ(a.matches.size(), b.matches.size());
  for (std::size_t k = 0; k < a.matches.size(); ++k) {
    const ScanMatch &x = a.matches[k], &y = b.matches[k];
    EXPECT_TRUE(x.pose.x_m == y.pose.x_m && x.pose.y_m == y.pose.y_m && x.pose.theta_rad == y.pose.theta_rad)
        << k;
    EXPECT_EQ(x.fit, y.fit) << k;
  }
  ASSERT_EQ(a.cells.size(), b.cells.size());
  for (std::size_t k = 0; k < a.cells.size(); ++k) {
    EXPECT_EQ(a.cells[k].first_i, b.cells[k].first_i) << k;
    EXPECT_EQ(a.cells[k].width, b.cells[k].width) << k;
    EXPECT_TRUE(test::same_bits(a.cells[k].cell, b.cells[k].cell)) << k;
  }
}

const Trace& by_one_thread() {
  static const Trace t = run(*make_cpu_scan_matcher(config(1)));
  return t;
}

TEST(MatchScans, KernelBodiesOnTheHostEqualTheOpenMpTwin) {
  expect_same(by_one_thread(), run(*cuda_on_host::make_scan_matcher_on_host(config(1))));
}

TEST(MatchScans, ThreadsDoNotMatter) {
  for (const int threads : {2, 5, 0})
    expect_same(by_one_thread(), run(*make_cpu_scan_matcher(config(threads))));
}

TEST(MatchScans, InstructionSetDoesNotMatter) {
  for (const cpu::Simd level : test::instruction_sets()) {
    const test::SimdLimit limit(level);
    expect_same(by_one_thread(), run(*make_cpu_scan_matcher(config(2))));
  }
}

TEST(MatchScans, GpuEqualsCpu) {
  std::unique_ptr<ScanMatcher> gpu;
  PARLOC_NEEDS_GPU(gpu = make_scan_matcher(BackendChoice::cuda, config(1)));
  expect_same(by_one_thread(), run(*gpu));
}

// Bits that agree say nothing if nothing was found.
TEST(MatchScans, ScansAreFoundWhereTheyWereTaken) {
  Scans scans;
  const auto matcher = make_cpu_scan_matcher(config(2));
  matcher->draw(drawings(scans, {}));
  const Pose truth = scans.at(1.1, 1.6, 0.3), start = compose(truth, {0.04, -0.06, 0.05});
  const BeamTable* scan = scans.from(truth, 180);
  const ClimbRules climb = matcher->rules().climb;
  const std::vector<ScanMatch> found =
      matcher->match({{2, scan, start, climb, {}}, {2, scan, start, {}, {}}, {7, scan, start, climb, {}}});
  EXPECT_LT(distance_m(found[0].pose, truth), 0.02);
  EXPECT_GT(found[0].fit, 0.7f);
  EXPECT_LT(found[1].fit, found[0].fit);
  EXPECT_GT(found[1].fit, 0.0f);
  EXPECT_EQ(found[1].pose.x_m, static_cast<double>(static_cast<float>(start.x_m)));
  EXPECT_EQ(found[2].fit, 0.0f);  // a map that nothing was drawn into
  // How well it fits there is what the climb says of where it ended.
  EXPECT_EQ(matcher->match({{2, scan, found[0].pose, {}, {}}})[0].fit, found[0].fit);
}

// So many beams from one place that counts are halved in between: in one call or one by one, with other maps
// beside or alone.
TEST(MatchScans, ScansOfAMapAreDrawnOneAfterTheOther) {
  Scans scans;
  std::vector<ScanDrawing> many;
  for (int k = 0; k < 50; ++k) {
    const Pose pose = scans.at(1.0 + 0.001 * k, 1.5, 0.0);
    many.push_back({k % 7 == 6 ? std::size_t{1} : 0, scans.from(pose, 900), pose});
  }
  const auto all = make_cpu_scan_matcher(config(2)), alone = make_cpu_scan_matcher(config(1));
  const auto kernels = cuda_on_host::make_scan_matcher_on_host(config(1));
  all->draw(many);
  kernels->draw(many);
  for (const ScanDrawing& d : many)
    if (d.map == 0) alone->draw({d});
  const SlamCells cells = all->cells(0);
  EXPECT_TRUE(test::same_bits(cells.cell, alone->cells(0).cell));
  EXPECT_TRUE(test::same_bits(cells.cell, kernels->cells(0).cell));
  kernels->clear();
  kernels->draw({many[0], many[49]});
  const SlamCells one = kernels->cells(0);
  alone->clear();
  alone->draw({many[0]});
  alone->draw({many[49]});
  EXPECT_EQ(one.span.first_j, alone->cells(0).span.first_j);
  EXPECT_EQ(one.span.size(), alone->cells(0).span.size());
  const auto passed = [](std::uint32_t most, CellWord w) { return std::max(most, visits_of(w)); };
  const std::uint32_t most = std::accumulate(cells.cell.begin(), cells.cell.end(), 0u, passed);
  EXPECT_LT(most, kMostVisits);
  std::size_t hits = 0;
  for (const ScanDrawing& d : many) hits += d.map == 0 ? d.scan->hits : 0;
  EXPECT_GT(hits, kMostVisits);  // all beams come from one cell or two
}

TEST(MatchScans, PosesTooFarApartAreRefused) {
  Scans scans;
  const BeamTable* scan = scans.from(scans.at(1.0, 1.5, 0.0), 90);
  for (const auto& matcher :
       {make_cpu_scan_matcher(config(1)), cuda_on_host::make_scan_matcher_on_host(config(1))})
    EXPECT_THROW(matcher->draw({{0, scan, {}}, {1, scan, {1e7, 0.0, 0.0}}}), Error);
}

}  // namespace
}  // namespace parloc
