// The global search as its users see it: known scenes, priors, ambiguity, hostile inputs.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/map/map_reader.h"
#include "common/math/portable64.h"
#include "common/search/global_search.h"
#include "common/search/hypotheses.h"
#include "common/search/search_parts.h"
#include "common/simulator/simulator.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

Scan simulated_scan(const GridMap& map, const Pose& pose, double fov_rad, double range_m,
                    const Pose& T_base_sensor = {}) {
  Scan scan{.T_base_sensor = T_base_sensor,
            .angle_min_rad = -0.5 * fov_rad,
            .angle_step_rad = fov_rad / 180.0,
            .range_min_m = 0.05,
            .range_max_m = range_m};
  const Pose sensor = compose(pose, T_base_sensor);
  for (int b = 0; b < 180; ++b)
    scan.ranges_m.push_back(static_cast<float>(
        cast_simulated_ray(map, sensor.x_m, sensor.y_m,
                           sensor.theta_rad + scan.angle_min_rad + scan.angle_step_rad * b, range_m)
            .range_m));
  return scan;
}

const ComputeConfig kOnCpu{.backend = BackendChoice::cpu};

void expect_within(const Pose& pose, const Pose& truth, double within_m, double within_rad) {
  EXPECT_LT(distance_m(pose, truth), within_m) << pose.x_m << " " << pose.y_m << " " << pose.theta_rad;
  EXPECT_LT(turn_rad(pose, truth), within_rad);
}

/// What is found where the scan was taken, first of all; all around if its field of view is not said.
void expect_found(GlobalSearch& search, const Scan& scan, const Pose& truth) {
  const SearchResult r = search.search(scan, StepConfig{});
  ASSERT_FALSE(r.hypotheses.empty());
  expect_within(r.hypotheses[0].pose, truth, 0.07, 0.01);
}

// The 1 cm drawing seen, the 5 cm map searched: its walls are up to half a cell off, and the field's ridge
// lies another half behind their faces. Together 5 cm at most along each axis.
TEST(Locate, FindsPlacesInTheHall) {
  const GridMap fine = read_map("maps/fine/hall_obstacles.yaml");
  GlobalSearch search(read_map("maps/hall_obstacles.yaml"), {}, kOnCpu);
  const Pose places[] = {{2.0, 2.0, 0.3}, {8.5, 4.0, -2.0}, {16.0, 7.5, 3.1}};
  for (const Pose& truth : places) {
    const SearchResult r = search.search(simulated_scan(fine, truth, 2 * kPi, 8.0), StepConfig{});
    ASSERT_FALSE(r.hypotheses.empty());
    expect_within(r.hypotheses[0].pose, truth, 0.07, 0.01);
    EXPECT_FALSE(r.ambiguous);
    EXPECT_GT(r.hypotheses[0].explained, 0.9);
    EXPECT_LT(r.hypotheses[0].through, 0.08);
  }
}

TEST(Locate, TheMountOfTheLidarAndTheMapsYawCount) {
  const GridMap fine = read_map("maps/fine/hall_obstacles.yaml");
  GridMap turned = read_map("maps/hall_obstacles.yaml");
  const Pose turn{3.0, -1.0, 0.7};
  turned.T_map_grid = compose(turn, turned.T_map_grid);
  GlobalSearch search(turned, {}, kOnCpu);
  const Pose truth{8.5, 4.0, -2.0};
  expect_found(search, simulated_scan(fine, truth, 4.0, 10.0, {0.4, -0.2, 2.5}), compose(turn, truth));
}

// An empty rectangle looks the same after half a turn.
TEST(Locate, ASymmetricPlaceIsAmbiguous) {
  const GridMap fine = read_map("maps/fine/hall.yaml");
  GlobalSearch search(read_map("maps/hall.yaml"), {}, kOnCpu);
  const Pose truth{6.0, 3.5, 0.5};
  const Scan scan = simulated_scan(fine, truth, 2 * kPi, 30.0);
  const SearchResult r = search.search(scan, StepConfig{});
  ASSERT_GE(r.hypotheses.size(), 2u);
  EXPECT_TRUE(r.ambiguous);
  const Pose mirrored{20.0 - truth.x_m, 10.0 - truth.y_m, wrap64(truth.theta_rad + kPi)};
  const bool first = distance_m(r.hypotheses[0].pose, truth) < 1.0;
  expect_within(r.hypotheses[first ? 0 : 1].pose, truth, 0.08, 0.02);
  expect_within(r.hypotheses[first ? 1 : 0].pose, mirrored, 0.08, 0.02);
  EXPECT_NEAR(r.hypotheses[0].weight, r.hypotheses[1].weight, 0.4);

  SearchPrior region, heading;
  region.region = {{truth.x_m + 0.5, truth.y_m, 2.0}};
  heading.heading = {{truth.theta_rad - 0.3, 0.5}};
  for (const SearchPrior& prior : {region, heading}) {
    const SearchResult known = search.search(scan, StepConfig{}, prior);
    ASSERT_FALSE(known.hypotheses.empty());
    EXPECT_FALSE(known.ambiguous);
    expect_within(known.hypotheses[0].pose, truth, 0.08, 0.02);
  }
  SearchPrior elsewhere;
  elsewhere.region = {{mirrored.x_m, mirrored.y_m, 1.0}};
  const SearchResult other = search.search(scan, StepConfig{}, elsewhere);
  ASSERT_FALSE(other.hypotheses.empty());
  expect_within(other.hypotheses[0].pose, mirrored, 0.08, 0.02);
}

TEST(Locate, HypothesesAreApartAndSorted) {
  const GridMap fine = read_map("maps/fine/office.yaml");
  SearchConfig config;
  config.most = 20;
  GlobalSearch search(read_map("maps/office.yaml"), config, kOnCpu);
  const SearchResult r = search.search(simulated_scan(fine, {15.0, 5.0, 1.0}, 1.7, 8.0), StepConfig{});
  ASSERT_GE(r.hypotheses.size(), 3u);
  double weights = 0.0;
  for (std::size_t a = 0; a < r.hypotheses.size(); ++a) {
    weights += r.hypotheses[a].weight;
    if (a > 0) {
      EXPECT_LE(r.hypotheses[a].evidence, r.hypotheses[a - 1].evidence);
    }
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_TRUE(separated(r.hypotheses[a].pose, r.hypotheses[b].pose,
                            {config.separation_m, config.separation_rad}));
  }
  EXPECT_LE(weights, 1.0 + 1e-9);
}

// A 1 cm map is searched in cells of 5 cm.
TEST(Locate, FineMapsArePooled) {
  const GridMap fine = read_map("maps/fine/hall_obstacles.yaml");
  GlobalSearch search(fine, {}, kOnCpu);
  EXPECT_EQ(SearchParts(search).map().pool, 5);
  EXPECT_DOUBLE_EQ(SearchParts(search).map().cell_m, 0.05);
  const Pose truth{8.5, 4.0, -2.0};
  expect_found(search, simulated_scan(fine, truth, 2 * kPi, 8.0), truth);
}

// Free space so thin that no cell of the search is half free: it is searched all the same.
TEST(Locate, AFineMapWithLittleFreeSpaceIsSearched) {
  std::vector<std::string> rows(40, "#" + std::string(38, '?') + "#");
  rows.front() = rows.back() = std::string(40, '#');
  rows[20][20] = '.';  // of 25 parts of its cell
  const GridMap map = grid_from_text(rows, 0.01);
  GlobalSearch search(map, {}, kOnCpu);
  EXPECT_EQ(SearchParts(search).map().free_count, 1u);
  const Pose truth{0.205, 0.195, 0.0};
  const SearchResult r = search.search(simulated_scan(map, truth, 2 * kPi, 8.0), StepConfig{});
  ASSERT_FALSE(r.hypotheses.empty());
  EXPECT_LT(distance_m(r.hypotheses[0].pose, truth), 0.07);
}

TEST(Locate, WallsThatAreSegments) {
  const GridMap map = read_map("maps/hall_segments.yaml");
  ASSERT_FALSE(map.walls.empty());
  GlobalSearch search(map, {}, kOnCpu);
  const Pose truth{8.5, 4.0, -2.0};
  expect_found(search, simulated_scan(map, truth, 2 * kPi, 8.0), truth);
}

template <class Work>
void expect_error(ErrorKind kind, Work&& work) {
  expect_none_of(error_of(work, kind), {"\n"});
}

TEST(Locate, AMapWithoutAFreeCellIsAnError) {
  expect_error(ErrorKind::input, [] { GlobalSearch(grid_from_text({"##", "#?"}, 0.05), {}, kOnCpu); });
}

TEST(Locate, ImpossibleSettingsAndPriorsAreErrors) {
  const GridMap map = grid_from_text({"....", "...."}, 0.5);
  SearchConfig config;
  config.beams = 257;
  expect_error(ErrorKind::config, [&] { GlobalSearch(map, config, kOnCpu); });
  config = {};
  config.sigma_m = std::nan("");
  expect_error(ErrorKind::config, [&] { GlobalSearch(map, config, kOnCpu); });
  GlobalSearch search(map, {}, kOnCpu);
  const Scan scan{.angle_step_rad = 1.0, .range_max_m = 5.0, .ranges_m = {1.0f, 1.0f}};
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const SearchPrior priors[] = {{.region = {{nan, 0, 1}}}, {.region = {{0, 0, -1}}},
                                {.region = {{0, 0, inf}}}, {.region = {{1e9, 0, 1}}},
                                {.heading = {{inf, 1}}},   {.heading = {{0, -1}}}};
  for (const SearchPrior& prior : priors)
    expect_error(ErrorKind::input, [&] { (void)search.search(scan, StepConfig{}, prior); });
}

Scan round_scan(std::size_t beams, float range_m, double range_max_m = 5.0) {
  return {.angle_step_rad = 0.1, .range_max_m = range_max_m, .ranges_m = std::vector<float>(beams, range_m)};
}
void expect_nothing(const GridMap& map, const Scan& scan) {
  EXPECT_TRUE(GlobalSearch(map, {}, kOnCpu).search(scan, StepConfig{}).hypotheses.empty());
}

TEST(Locate, ScansAndMapsWithNothingInThemGiveNoHypothesis) {
  const GridMap hall = read_map("maps/hall.yaml");
  expect_nothing(hall, round_scan(0, 0.0f));
  expect_nothing(hall, round_scan(60, std::nanf("")));
  expect_nothing(hall, round_scan(60, 5.0f));  // misses only
  // Smaller than a block, and no wall.
  expect_nothing(grid_from_text({"....", "....", "...."}, 0.05), round_scan(60, 2.0f));
  expect_nothing(grid_from_text({"."}, 0.05), round_scan(60, 2.0f));
}

// Beams that end far off any map, and one that is at 1e30 m.
TEST(Locate, AScanFartherThanTheMapDoesNoHarm) {
  Scan scan = round_scan(60, 1e30f, 1e31);
  for (std::size_t b = 0; b < 60; b += 2) scan.ranges_m[b] = 3000.0f;
  expect_nothing(read_map("maps/hall.yaml"), scan);
}

// Every beam ends 1 m off: nowhere in a hall of 20 x 10 m.
TEST(Locate, AScanThatFitsNowhereGivesNoHypothesisOrAPoorOne) {
  const Scan scan = round_scan(60, 0.5f);
  GlobalSearch search(read_map("maps/hall.yaml"), {}, kOnCpu);
  const SearchResult r = search.search(scan, StepConfig{});
  for (const Hypothesis& h : r.hypotheses) EXPECT_LT(h.explained, 0.6);
}

}  // namespace
}  // namespace parloc
