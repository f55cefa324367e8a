// The global search as its users see it: known scenes, priors, ambiguity, hostile inputs.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/error.h"
#include "common/map/map_reader.h"
#include "common/math/portable64.h"
#include "common/search/global_search.h"
#include "common/search/hypotheses.h"
#include "common/search/search_map.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

Scan simulated_scan(const GridMap& map, const Pose& pose, double fov_rad, double range_m,
                    const Pose& T_base_sensor = {}) {
  Scan scan;
  scan.T_base_sensor = T_base_sensor;
  scan.angle_min_rad = -0.5 * fov_rad;
  scan.angle_step_rad = fov_rad / 180.0;
  scan.range_min_m = 0.05;
  scan.range_max_m = range_m;
  const Pose sensor = compose(pose, T_base_sensor);
  for (int b = 0; b < 180; ++b)
    scan.ranges_m.push_back(static_cast<float>(
        cast_simulated_ray(map, sensor.x_m, sensor.y_m,
                           sensor.theta_rad + scan.angle_min_rad + scan.angle_step_rad * b, range_m)
            .range_m));
  return scan;
}

const ComputeConfig kOnCpu{.backend = BackendChoice::cpu};

void expect_near(const Pose& pose, const Pose& truth, double within_m, double within_rad) {
  EXPECT_LT(std::hypot(pose.x_m - truth.x_m, pose.y_m - truth.y_m), within_m)
      << pose.x_m << " " << pose.y_m << " " << pose.theta_rad;
  EXPECT_LT(std::fabs(wrap64(pose.theta_rad - truth.theta_rad)), within_rad);
}

// The 1 cm drawing seen, the 5 cm map searched: its walls are up to half a cell off, and the field's ridge
// lies another half behind their faces. Together 5 cm at most along each axis.
TEST(Locate, FindsPlacesInTheHall) {
  const GridMap fine = read_map("maps/fine/hall_obstacles.yaml");
  GlobalSearch search(read_map("maps/hall_obstacles.yaml"), {}, kOnCpu);
  const Pose places[] = {{2.0, 2.0, 0.3}, {8.5, 4.0, -2.0}, {16.0, 7.5, 3.1}};
  for (const Pose& truth : places) {
    const SearchResult r = search.search(simulated_scan(fine, truth, 2 * kPi, 8.0), ScanConfig{});
    ASSERT_FALSE(r.hypotheses.empty());
    expect_near(r.hypotheses[0].pose, truth, 0.07, 0.01);
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
  const Scan scan = simulated_scan(fine, truth, 4.0, 10.0, {0.4, -0.2, 2.5});
  const SearchResult r = search.search(scan, ScanConfig{});
  ASSERT_FALSE(r.hypotheses.empty());
  expect_near(r.hypotheses[0].pose, compose(turn, truth), 0.07, 0.01);
}

// An empty rectangle looks the same after half a turn.
TEST(Locate, ASymmetricPlaceIsAmbiguous) {
  const GridMap fine = read_map("maps/fine/hall.yaml");
  GlobalSearch search(read_map("maps/hall.yaml"), {}, kOnCpu);
  const Pose truth{6.0, 3.5, 0.5};
  const SearchResult r = search.search(simulated_scan(fine, truth, 2 * kPi, 30.0), ScanConfig{});
  ASSERT_GE(r.hypotheses.size(), 2u);
  EXPECT_TRUE(r.ambiguous);
  const Pose mirrored{20.0 - truth.x_m, 10.0 - truth.y_m, wrap64(truth.theta_rad + kPi)};
  const bool first =
      std::hypot(r.hypotheses[0].pose.x_m - truth.x_m, r.hypotheses[0].pose.y_m - truth.y_m) < 1.0;
  expect_near(r.hypotheses[first ? 0 : 1].pose, truth, 0.08, 0.02);
  expect_near(r.hypotheses[first ? 1 : 0].pose, mirrored, 0.08, 0.02);
  EXPECT_NEAR(r.hypotheses[0].weight, r.hypotheses[1].weight, 0.4);

  SearchPrior region, heading;
  region.region = {{truth.x_m + 0.5, truth.y_m, 2.0}};
  heading.heading = {{truth.theta_rad - 0.3, 0.5}};
  for (const SearchPrior& prior : {region, heading}) {
    const SearchResult known = search.search(simulated_scan(fine, truth, 2 * kPi, 30.0), ScanConfig{}, prior);
    ASSERT_FALSE(known.hypotheses.empty());
    EXPECT_FALSE(known.ambiguous);
    expect_near(known.hypotheses[0].pose, truth, 0.08, 0.02);
  }
  SearchPrior elsewhere;
  elsewhere.region = {{mirrored.x_m, mirrored.y_m, 1.0}};
  const SearchResult other =
      search.search(simulated_scan(fine, truth, 2 * kPi, 30.0), ScanConfig{}, elsewhere);
  ASSERT_FALSE(other.hypotheses.empty());
  expect_near(other.hypotheses[0].pose, mirrored, 0.08, 0.02);
}

TEST(Locate, HypothesesAreApartAndSorted) {
  const GridMap fine = read_map("maps/fine/office.yaml");
  SearchConfig config;
  config.most = 20;
  GlobalSearch search(read_map("maps/office.yaml"), config, kOnCpu);
  const SearchResult r = search.search(simulated_scan(fine, {15.0, 5.0, 1.0}, 1.7, 8.0), ScanConfig{});
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
  EXPECT_EQ(search.map().pool, 5);
  EXPECT_DOUBLE_EQ(search.map().cell_m, 0.05);
  const Pose truth{8.5, 4.0, -2.0};
  const SearchResult r = search.search(simulated_scan(fine, truth, 2 * kPi, 8.0), ScanConfig{});
  ASSERT_FALSE(r.hypotheses.empty());
  expect_near(r.hypotheses[0].pose, truth, 0.07, 0.01);
}

// Free space so thin that no cell of the search is half free: it is searched all the same.
TEST(Locate, AFineMapWithLittleFreeSpaceIsSearched) {
  std::vector<std::string> rows(40, "#" + std::string(38, '?') + "#");
  rows.front() = rows.back() = std::string(40, '#');
  rows[20][20] = '.';  // of 25 parts of its cell
  const GridMap map = grid_from_text(rows, 0.01);
  GlobalSearch search(map, {}, kOnCpu);
  EXPECT_EQ(search.map().free_count, 1u);
  const Pose truth{0.205, 0.195, 0.0};
  const SearchResult r = search.search(simulated_scan(map, truth, 2 * kPi, 8.0), ScanConfig{});
  ASSERT_FALSE(r.hypotheses.empty());
  EXPECT_LT(std::hypot(r.hypotheses[0].pose.x_m - truth.x_m, r.hypotheses[0].pose.y_m - truth.y_m), 0.07);
}

TEST(Locate, WallsThatAreSegments) {
  const GridMap map = read_map("maps/hall_segments.yaml");
  ASSERT_FALSE(map.walls.empty());
  GlobalSearch search(map, {}, kOnCpu);
  const Pose truth{8.5, 4.0, -2.0};
  const SearchResult r = search.search(simulated_scan(map, truth, 2 * kPi, 8.0), ScanConfig{});
  ASSERT_FALSE(r.hypotheses.empty());
  expect_near(r.hypotheses[0].pose, truth, 0.07, 0.01);
}

ErrorKind kind_of_failure(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    return e.kind();
  }
  ADD_FAILURE() << "no error";
  return ErrorKind::internal;
}

TEST(Locate, AMapWithoutAFreeCellIsAnError) {
  EXPECT_EQ(kind_of_failure([] {
              GlobalSearch(grid_from_text({"##", "#?"}, 0.05), {}, kOnCpu);
            }),
            ErrorKind::input);
}

TEST(Locate, ImpossibleSettingsAndPriorsAreErrors) {
  const GridMap map = grid_from_text({"....", "...."}, 0.5);
  SearchConfig config;
  config.beams = 257;
  EXPECT_EQ(kind_of_failure([&] { GlobalSearch(map, config, kOnCpu); }), ErrorKind::config);
  config = {};
  config.sigma_m = std::nan("");
  EXPECT_EQ(kind_of_failure([&] { GlobalSearch(map, config, kOnCpu); }), ErrorKind::config);
  GlobalSearch search(map, {}, kOnCpu);
  Scan scan;
  scan.ranges_m = {1.0f, 1.0f};
  scan.angle_step_rad = 1.0;
  scan.range_max_m = 5.0;
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const SearchPrior::Disc disc : {SearchPrior::Disc{nan, 0, 1}, SearchPrior::Disc{0, 0, -1},
                                       SearchPrior::Disc{0, 0, inf}, SearchPrior::Disc{1e9, 0, 1}}) {
    SearchPrior prior;
    prior.region = disc;
    EXPECT_EQ(kind_of_failure([&] { (void)search.search(scan, ScanConfig{}, prior); }), ErrorKind::input);
  }
  for (const SearchPrior::Interval interval : {SearchPrior::Interval{inf, 1}, SearchPrior::Interval{0, -1}}) {
    SearchPrior prior;
    prior.heading = interval;
    EXPECT_EQ(kind_of_failure([&] { (void)search.search(scan, ScanConfig{}, prior); }), ErrorKind::input);
  }
}

TEST(Locate, ScansAndMapsWithNothingInThemGiveNoHypothesis) {
  Scan scan;
  scan.angle_step_rad = 0.1;
  scan.range_max_m = 5.0;
  const GridMap hall = read_map("maps/hall.yaml");
  GlobalSearch search(hall, {}, kOnCpu);
  EXPECT_TRUE(search.search(scan, ScanConfig{}).hypotheses.empty());  // no beam at all
  scan.ranges_m.assign(60, std::nanf(""));
  EXPECT_TRUE(search.search(scan, ScanConfig{}).hypotheses.empty());
  scan.ranges_m.assign(60, 5.0f);  // misses only
  EXPECT_TRUE(search.search(scan, ScanConfig{}).hypotheses.empty());
  scan.ranges_m.assign(60, 2.0f);
  GridMap open = grid_from_text({"....", "....", "...."}, 0.05);  // smaller than a block, and no wall
  GlobalSearch nowhere(open, {}, kOnCpu);
  EXPECT_TRUE(nowhere.search(scan, ScanConfig{}).hypotheses.empty());
  GlobalSearch one_cell(grid_from_text({"."}, 0.05), {}, kOnCpu);
  EXPECT_TRUE(one_cell.search(scan, ScanConfig{}).hypotheses.empty());
}

// Beams that end far off any map, and one that is at 1e30 m.
TEST(Locate, AScanFartherThanTheMapDoesNoHarm) {
  Scan scan;
  scan.angle_step_rad = 0.1;
  scan.range_max_m = 1e31;
  scan.ranges_m.assign(60, 1e30f);
  for (std::size_t b = 0; b < 60; b += 2) scan.ranges_m[b] = 3000.0f;
  GlobalSearch search(read_map("maps/hall.yaml"), {}, kOnCpu);
  EXPECT_TRUE(search.search(scan, ScanConfig{}).hypotheses.empty());
}

// Every beam ends 1 m off: nowhere in a hall of 20 x 10 m.
TEST(Locate, AScanThatFitsNowhereGivesNoHypothesisOrAPoorOne) {
  Scan scan;
  scan.angle_step_rad = 0.1;
  scan.range_max_m = 5.0;
  scan.ranges_m.assign(60, 0.5f);
  GlobalSearch search(read_map("maps/hall.yaml"), {}, kOnCpu);
  const SearchResult r = search.search(scan, ScanConfig{});
  for (const Hypothesis& h : r.hypotheses) EXPECT_LT(h.explained, 0.6);
}

}  // namespace
}  // namespace parloc
