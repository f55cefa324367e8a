// `parloc bench`: the published figures, what is measured, and whole measurements.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

#include "common/simulator/simulator.h"
#include "tests/unit/expect.h"
#include "tests/unit/timing_rules.h"
#include "tools/bench/forms.h"
#include "tools/bench/plan.h"
#include "tools/bench/published.h"
#include "tools/bench/steps/measure.h"
#include "tools/bench/steps/memory.h"
#include "tools/bench/steps/rig.h"
#include "tools/bench/steps/scenes.h"
#include "tools/bench/steps/variants.h"

namespace parloc::tools::bench {
namespace {

using Json = nlohmann::json;

const std::string kMaps = "maps";  // tests run in the repository's root

// ---- the published tables ----------------------------------------------------------------------------

/// Rows N, columns M = 50, 100, 200; dual core, GTX 560, Opteron: as the specification has them, typed in
/// once more.
constexpr const char* kTyped = R"(
500  .0241 .0471 .0933  .0084 .0168 .0353  .0016 .0056 .0104
1000 .0488 .0949 .1870  .0164 .0324 .0671  .0069 .0121 .0210
2000 .1006 .1926 .3774  .0253 .0498 .1015  .0160 .0260 .0427
3000 .1562 .2942 .5707  .0339 .0671 .1306  .0281 .0420 .0692
4000 .2141 .3983 .7679  .0421 .0834 .1642  .0408 .0592 .0975
)";

double published(std::size_t table, std::int64_t particles, int beams) {
  return published_seconds(published_tables()[table], particles, beams).value();
}

TEST(Published, TablesAreThoseOfThePaper) {
  std::istringstream typed(kTyped);
  std::int64_t particles = 0;
  int rows = 0;
  for (; typed >> particles; ++rows) {
    for (std::size_t table = 0; table < 3; ++table) {
      for (const int beams : {50, 100, 200}) {
        double seconds = 0.0;
        ASSERT_TRUE(typed >> seconds);
        EXPECT_EQ(published(table, particles, beams), seconds) << table << ' ' << particles << ' ' << beams;
      }
    }
  }
  EXPECT_EQ(rows, 5);
  EXPECT_FALSE(published_seconds(published_tables()[0], 600, 50));
  EXPECT_FALSE(published_seconds(published_tables()[0], 500, 51));
}

/// What the specification derives from them.
TEST(Published, DerivedFiguresAreRight) {
  std::vector<int> within;
  for (std::size_t table = 0; table < 3; ++table) {
    int count = 0;
    for (const std::int64_t n : kPublishedParticles)
      for (const int m : kPublishedBeams) count += published(table, n, m) <= kBudget_s ? 1 : 0;
    within.push_back(count);
  }
  EXPECT_EQ(within, (std::vector<int>{1, 7, 9}));

  const double largest = 4000.0 * 200.0;
  EXPECT_NEAR(largest / published(0, 4000, 200), 1.04e6, 0.005e6);
  EXPECT_NEAR(largest / published(1, 4000, 200), 4.87e6, 0.005e6);
  EXPECT_NEAR(largest / published(2, 4000, 200), 8.21e6, 0.005e6);

  std::vector<double> ratios;  // GPU over Opteron
  for (const std::int64_t n : kPublishedParticles)
    for (const int m : kPublishedBeams) ratios.push_back(published(1, n, m) / published(2, n, m));
  EXPECT_NEAR(*std::min_element(ratios.begin(), ratios.end()), 1.03, 0.005);
  EXPECT_NEAR(*std::max_element(ratios.begin(), ratios.end()), 5.25, 0.005);
  EXPECT_NEAR(std::accumulate(ratios.begin(), ratios.end(), 0.0) / 15.0, 2.31, 0.005);

  // 2 T50 - T100 cancels the rays: flat on the GPU, growing with N^2 on the others.
  const auto without_rays = [](std::size_t table, std::int64_t n) {
    return 1e3 * (2.0 * published(table, n, 50) - published(table, n, 100));
  };
  for (const std::int64_t n : {1000, 2000, 3000, 4000}) {
    EXPECT_GE(without_rays(1, n), 0.35) << n;
    EXPECT_LE(without_rays(1, n), 0.85) << n;
  }
  EXPECT_NEAR(without_rays(0, 1000), 2.7, 0.05);
  EXPECT_NEAR(without_rays(0, 4000), 29.9, 0.05);
  EXPECT_NEAR(without_rays(2, 1000), 1.7, 0.05);
  EXPECT_NEAR(without_rays(2, 4000), 22.4, 0.05);
}

// ---- scenes --------------------------------------------------------------------------------------------

std::size_t occupied(const GridMap& map) {
  return static_cast<std::size_t>(std::count(map.cells.begin(), map.cells.end(), Cell::occupied));
}

TEST(Scenes, HaveTheSizesThatAreStated) {
  struct Stated {
    const char* name;
    int width, height;
    double occupied_percent;
  };
  for (const Stated& stated : {Stated{"no_hit", 800, 600, 0.0},
                               {"hall", 400, 200, 1.5},
                               {"hall_obstacles", 400, 200, 4.3},
                               {"office", 1080, 666, 9.3}}) {
    const Scene scene = make_scene(stated.name, kMaps);
    EXPECT_EQ(scene.name, stated.name);
    EXPECT_EQ(scene.map.width, stated.width) << stated.name;
    EXPECT_EQ(scene.map.height, stated.height) << stated.name;
    EXPECT_DOUBLE_EQ(scene.map.resolution_m, 0.05) << stated.name;
    const double percent =
        100.0 * static_cast<double>(occupied(scene.map)) / static_cast<double>(scene.map.size());
    EXPECT_NEAR(percent, stated.occupied_percent, 0.05) << stated.name;
    EXPECT_EQ(scene.map.at_point(scene.pose.x_m, scene.pose.y_m), Cell::free) << stated.name;
  }
}

TEST(Scenes, NoRayHitsInTheWorstCase) {
  const Scene scene = make_scene("no_hit", "no such folder");  // it needs none
  for (const Cloud kind : {Cloud::tracking, Cloud::global}) {
    const ParticleSet cloud = make_cloud(scene, kind, 2000);
    for (std::size_t i = 0; i < cloud.x.size(); ++i) {
      // The central 20 x 10 m: at least 8 m of empty cells to every side.
      EXPECT_GE(cloud.x[i], 10.0f);
      EXPECT_LE(cloud.x[i], 30.0f);
      EXPECT_GE(cloud.y[i], 10.0f);
      EXPECT_LE(cloud.y[i], 20.0f);
    }
  }
  const Scan scan = make_scan(scene, 50);
  for (const float range_m : scan.ranges_m) EXPECT_EQ(range_m, 8.0f);
}

TEST(Scenes, GlobalCloudsCoverTheFreeCells) {
  const Scene scene = make_scene("hall_obstacles", kMaps);
  const ParticleSet cloud = make_cloud(scene, Cloud::global, 4000);
  std::array<int, 4> quarters{};
  for (std::size_t i = 0; i < cloud.x.size(); ++i) {
    EXPECT_EQ(scene.map.at_point(cloud.x[i], cloud.y[i]), Cell::free);
    ++quarters[(cloud.x[i] < 10.0f ? 0u : 1u) + (cloud.y[i] < 5.0f ? 0u : 2u)];
  }
  for (const int quarter : quarters)
    EXPECT_NEAR(quarter, 1000, 200);  // free areas differ; sd of a count is 27
}

TEST(Scenes, TrackingCloudsAreAboutThePose) {
  const Scene scene = make_scene("office", kMaps);
  const ParticleSet cloud = make_cloud(scene, Cloud::tracking, 4000);
  double x = 0.0, xx = 0.0, t = 0.0, tt = 0.0;
  for (std::size_t i = 0; i < cloud.x.size(); ++i) {
    const double dx = cloud.x[i] + scene.map.T_map_grid.x_m - scene.pose.x_m;
    const double dt = cloud.theta[i] - scene.pose.theta_rad;
    x += dx / 4000, xx += dx * dx / 4000, t += dt / 4000, tt += dt * dt / 4000;
  }
  EXPECT_NEAR(x, 0.0, 0.015);  // 5 sd of the mean
  EXPECT_NEAR(t, 0.0, 0.008);
  EXPECT_NEAR(std::sqrt(xx), 0.2, 0.012);  // 5 sd of the sd
  EXPECT_NEAR(std::sqrt(tt), 0.1, 0.006);
}

TEST(Scenes, ScansAreEvenAndNoisy) {
  const Scene scene = make_scene("hall_obstacles", kMaps);
  const Scan scan = make_scan(scene, 1080);
  ASSERT_EQ(scan.ranges_m.size(), 1080u);
  EXPECT_NEAR(scan.angle_min_rad, -0.75 * M_PI, 1e-12);
  EXPECT_NEAR(scan.angle_min_rad + 1079 * scan.angle_step_rad, 0.75 * M_PI, 1e-12);
  double sum = 0.0, squares = 0.0;
  int hits = 0;
  for (std::size_t k = 0; k < 1080; ++k) {
    const double angle_rad =
        scene.pose.theta_rad + scan.angle_min_rad + static_cast<double>(k) * scan.angle_step_rad;
    const SimulatedHit hit = cast_simulated_ray(scene.map, scene.pose.x_m, scene.pose.y_m, angle_rad, 8.0);
    if (!hit.hit) continue;
    const double error_m = scan.ranges_m[k] - hit.range_m;
    sum += error_m, squares += error_m * error_m, ++hits;
  }
  ASSERT_GT(hits, 500);
  EXPECT_NEAR(sum / hits, 0.0, 5 * 0.02 / std::sqrt(hits));
  EXPECT_NEAR(std::sqrt(squares / hits), 0.02, 5 * 0.02 / std::sqrt(2.0 * hits));
  EXPECT_EQ(make_scan(scene, 1080).ranges_m, scan.ranges_m);  // a fixed seed
}

TEST(Scenes, WhatIsMissingIsSaid) {
  expect_parts(error_of([] { make_scene("cellar", kMaps); }, ErrorKind::usage), {"hall_obstacles"});
  expect_parts(error_of([] { find_maps_folder("no/such/folder"); }), {"no/such/folder"});
  EXPECT_NO_THROW(make_scene("hall", find_maps_folder("")));
  EXPECT_THROW(make_scene("hall", "configs"), Error);  // a folder without that map
}

// ---- variants and rigs ---------------------------------------------------------------------------------

TEST(Variants, AreTheTwoAlgorithmsOnOneThreadAndOnAll) {
  const std::vector<Algorithm> both{Algorithm::paz2012, Algorithm::parloc};
  std::vector<std::string> names;
  for (const Variant& v : choose_variants(both, 3).variants) {
    if (v.backend == BackendChoice::cpu) names.push_back(name_of(v));
  }
  EXPECT_EQ(names, (std::vector<std::string>{"paz2012, 1 thread", "paz2012, 3 threads", "parloc, 1 thread",
                                             "parloc, 3 threads"}));
  const VariantChoice alone = choose_variants({Algorithm::paz2012}, 1);
  ASSERT_EQ(alone.variants.size(), 1u);
  ASSERT_EQ(alone.notes.size(), 1u);
  expect_parts(alone.notes[0], {"one thread"});
}

TEST(Variants, UseTheSettingsThatTheirNamesPromise) {
  const FilterBackendConfig published = backend_config({Algorithm::paz2012, BackendChoice::cpu, 1, 0}, 10);
  EXPECT_EQ(published.sensor.caster, RayCaster::fixed_step);
  EXPECT_EQ(published.sensor.fixed_step_cells, 0.5);
  EXPECT_EQ(published.resample.scheme, ResampleScheme::multinomial_linear);
  const FilterBackendConfig ours = backend_config({Algorithm::parloc, BackendChoice::cpu, 2, 0}, 10);
  EXPECT_EQ(ours.sensor.caster, RayCaster::skip);
  EXPECT_EQ(ours.resample.scheme, ResampleScheme::systematic);
  EXPECT_EQ(ours.threads, 2);
  for (const FilterBackendConfig& c : {published, ours}) {
    EXPECT_EQ(c.sensor.model, SensorModel::gaussian);
    EXPECT_EQ(c.sensor.sigma_hit, 0.1);
    EXPECT_EQ(c.sensor.tempering, 1.0);
    EXPECT_GE(c.resample.threshold, 1.0);  // every step
    EXPECT_EQ(c.particles, 10);
  }
}

/// A step that finds the robot has done all of its work.
TEST(Rig, StepsLocalize) {
  const Scene scene = make_scene("hall_obstacles", kMaps);
  for (const Algorithm algorithm : {Algorithm::paz2012, Algorithm::parloc}) {
    Rig rig({algorithm, BackendChoice::cpu, 2, 0}, scene, Cloud::tracking, 2000);
    rig.use_beams(100);
    for (int k = 0; k < 2; ++k) {  // the second starts from the same cloud
      EXPECT_GT(rig.step_seconds(), 0.0);
      const StepState& state = rig.last();
      EXPECT_EQ(state.resample, 1u);
      EXPECT_EQ(state.degenerate, 0u);
      // The clouds drive on by 5 cm, the scan stays; the filter follows the scan. 5 cm is a cell.
      EXPECT_NEAR(state.all.x, scene.pose.x_m, 0.05) << kAlgorithmNames[static_cast<std::size_t>(algorithm)];
      EXPECT_NEAR(state.all.y, scene.pose.y_m, 0.05);
      EXPECT_NEAR(state.all.theta, scene.pose.theta_rad, 0.03);
      EXPECT_LT(state.n_eff, 500.0);
    }
    const double x_m = rig.last().all.x;
    const StageSeconds stages = rig.stage_seconds();
    for (const double seconds : stages) EXPECT_GE(seconds, 0.0);
    EXPECT_GT(stages[2], stages[0]) << "casting 200000 rays takes longer than moving 2000 particles";
    EXPECT_NE(rig.last().all.x, x_m) << "new random numbers in every step";
  }
}

TEST(Rig, NoHitWeighsAllAlike) {
  const Scene scene = make_scene("no_hit", "");
  Rig rig({Algorithm::parloc, BackendChoice::cpu, 1, 0}, scene, Cloud::global, 500);
  rig.use_beams(50);
  rig.step_seconds();
  EXPECT_NEAR(rig.last().n_eff, 500.0, 1e-6);
  EXPECT_EQ(rig.last().resample, 1u);
}

TEST(Memory, TooLargeIsSaidBefore) {
  const Variant cpu{Algorithm::parloc, BackendChoice::cpu, 1, 0};
  EXPECT_EQ(too_large(cpu, 1000, std::nullopt), "");
  EXPECT_EQ(too_large(cpu, 1000, needed_bytes(cpu, 1000)), "");
  const std::string why = too_large(cpu, std::int64_t{1} << 24, std::uint64_t{1} << 30);
  expect_parts(why, {"1.07 GB are available"});
  // 16 M particles take 81 bytes each (measured: 1 M take 96 MB more than one), and the cloud kept beside
  // them 16.
  EXPECT_GT(needed_bytes(cpu, std::int64_t{1} << 24), std::uint64_t{1'600'000'000});
  EXPECT_LT(needed_bytes(cpu, std::int64_t{1} << 24), std::uint64_t{2'000'000'000});
  const std::uint64_t available = std::uint64_t{1} << 30;
  const std::int64_t most = particles_in_memory(cpu, std::int64_t{1} << 24, available);
  EXPECT_EQ(too_large(cpu, most, available), "");
  EXPECT_NE(too_large(cpu, most + 1, available), "");
  EXPECT_EQ(particles_in_memory(cpu, 5000, available), 5000);
  EXPECT_EQ(particles_in_memory(cpu, 5000, 1000), 0);
  EXPECT_GT(available_bytes().value_or(1), 0u);
}

// ---- whole measurements --------------------------------------------------------------------------------

/// Every step is measured once.
class Run : public testing::Test {
 protected:
  Run() {
    plan.scenes = {"no_hit"};
    plan.clouds = {Cloud::tracking};
    plan.algorithms = {Algorithm::paz2012, Algorithm::parloc};
    plan.threads = 1;
    plan.max_particles = 1000;
    plan.max_beams = 100;
    results.rules = rules_of(0.0, 1, 1);
  }
  void measure() { measure_tables(plan, scenes, control, results); }

  Plan plan;
  const std::vector<Scene> scenes{make_scene("no_hit", "")};
  Control control;
  Results results;
};

TEST_F(Run, MeasuresEverySizeWithEveryVariant) {
  measure();
  EXPECT_FALSE(results.interrupted);
  EXPECT_TRUE(results.skipped.empty());
  const std::size_t cpu_rows =
      static_cast<std::size_t>(std::count_if(results.rows.begin(), results.rows.end(), [&](const Row& row) {
        return results.variants[row.variant].backend == BackendChoice::cpu;
      }));
  EXPECT_EQ(cpu_rows, 2u * 2 * 2);  // 500 and 1000 particles, 50 and 100 beams, two algorithms
  for (const Row& row : results.rows) {
    EXPECT_GT(row.time.median_s, 0.0);
    EXPECT_FALSE(results.backends[row.variant].empty());
  }
}

TEST_F(Run, InterruptedKeepsWhatIsFinished) {
  control.stop = [&] { return results.rows.size() >= 3; };
  measure();
  EXPECT_TRUE(results.interrupted);
  EXPECT_EQ(results.rows.size(), 3u);
  EXPECT_EQ(Json::parse(json_text(results)).at("interrupted"), true);
}

TEST_F(Run, WithoutTimeLeftSaysWhatWasSkipped) {
  control.deadline = Clock::now();
  measure();
  EXPECT_TRUE(results.rows.empty());
  ASSERT_GE(results.skipped.size(), 8u);
  expect_parts(results.skipped[0].why, {"time"});
  expect_parts(results.skipped[0].what, {"500 x 50"});
}

TEST_F(Run, ScaleMeasuresStagesAndTheLargest) {
  plan.max_particles = 2000;
  plan.threads = 2;
  plan.quick = true;
  results.scale = true;
  measure_scale(plan, scenes, control, results);
  const Place place{"no_hit", "tracking"};
  for (const Sweep sweep : {Sweep::particles, Sweep::beams, Sweep::threads}) {
    EXPECT_FALSE(results.variants_of(sweep, place).empty()) << kSweepNames[static_cast<int>(sweep)];
  }
  for (const Row& row : results.rows) EXPECT_TRUE(row.stages.has_value());
  ASSERT_GE(results.largest.size(), 3u);
  for (const Largest& l : results.largest) {
    EXPECT_LE(l.particles, 2000);
    EXPECT_TRUE(l.too_many > 0 || l.limit == "--max-particles") << l.limit;
  }
}

TEST(Scale, SizesAreThoseOfTheDocumentation) {
  Plan plan;
  plan.max_particles = kMaxParticles;
  plan.max_beams = 4096;
  const auto sizes = scale_particles(plan);
  ASSERT_EQ(sizes.size(), 8u);
  EXPECT_EQ(sizes.front(), 1024);
  EXPECT_EQ(sizes.back(), 16'777'216);
  EXPECT_EQ(scale_beams(plan).front(), 50);
  EXPECT_EQ(scale_beams(plan).back(), 1080);
  EXPECT_EQ(scale_threads(2, false), (std::vector<int>{1, 2}));
  EXPECT_EQ(scale_threads(16, false), (std::vector<int>{1, 2, 3, 4, 6, 8, 12, 16}));
  EXPECT_EQ(scale_threads(10, false), (std::vector<int>{1, 2, 3, 4, 6, 8, 10}));
  EXPECT_EQ(scale_threads(16, true), (std::vector<int>{1, 16}));
}

}  // namespace
}  // namespace parloc::tools::bench
