// Rays of whole scans against 10 to 100,000 walls: the search by cell, in SIMD lanes, gives the identical
// range that trying every wall gives. PARLOC_RAYS: how many rays in all (default 50,000; 10 million take a
// while).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "common/filter/filter_backend.h"
#include "common/filter/start.h"

namespace parloc {
namespace {

std::size_t rays_in_all() {
  const char* text = std::getenv("PARLOC_RAYS");
  return text == nullptr ? 50000 : static_cast<std::size_t>(std::strtoull(text, nullptr, 10));
}

/// Walls of up to 4 m, half of them in chains, some along the axes, in a grid of `side` x `side` cells of 0.1
/// m.
GridMap random_walls(std::size_t count, std::int32_t side) {
  GridMap map;
  map.width = map.height = side, map.resolution_m = 0.1;
  map.cells.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), Cell::free);
  const float far_m = 0.1f * static_cast<float>(side) - 1.0f;
  std::mt19937 random(static_cast<std::uint32_t>(count));
  std::uniform_real_distribution<float> place(1.0f, far_m), step(-2.8f, 2.8f);
  float ax = place(random), ay = place(random);
  while (map.walls.size() < count) {
    const bool upright = random() % 4 == 0, round = random() % 8 == 0;
    float bx = upright ? ax : std::clamp(ax + step(random), 1.0f, far_m);
    float by = std::clamp(ay + step(random), 1.0f, far_m);
    if (round) bx = std::round(bx), by = std::round(by);
    map.walls.push_back({ax, ay, bx, by});
    const bool chain = random() % 2 == 0;
    ax = chain ? bx : place(random), ay = chain ? by : place(random);
  }
  return map;
}

/// 200 beams all around, of 30 m.
BeamTable all_around() {
  const Scan scan{.angle_min_rad = -3.14159,
                  .angle_step_rad = 3.14159 / 100,
                  .range_min_m = 0.01,
                  .range_max_m = 30.0,
                  .ranges_m = std::vector<float>(200, 5.0f)};
  BeamTable beams;
  BeamCounts counts;
  select_beams(scan, ScanConfig{.max_beams = 200}, default_sensor(SensorModel::gaussian), 0.1, beams, counts);
  return beams;
}

std::vector<float> ranges(const GridMap& map, RayCaster caster, std::int64_t particles) {
  FilterBackendConfig c{.particles = particles, .sensor = default_sensor(SensorModel::gaussian)};
  c.sensor.caster = caster;
  const auto backend = make_cpu_filter_backend(c);
  backend->set_map(map);
  backend->upload(uniform_start(map, particles, 11));
  backend->set_scan(all_around());
  return backend->ray_trace();
}

struct Case {
  std::size_t walls;
  std::int32_t side;  // [cells]
  double share;       // of all rays: brute force takes rays times walls
};

class WallSearch : public ::testing::TestWithParam<Case> {};

TEST_P(WallSearch, FindsTheIdenticalRanges) {
  const GridMap map = random_walls(GetParam().walls, GetParam().side);
  const auto particles =
      static_cast<std::int64_t>(GetParam().share * static_cast<double>(rays_in_all()) / 200.0 + 0.5);
  const std::vector<float> by_cell = ranges(map, RayCaster::skip, particles),
                           every = ranges(map, RayCaster::dda, particles);
  ASSERT_EQ(by_cell.size(), every.size());
  std::size_t different = 0, hits = 0;
  for (std::size_t k = 0; k < every.size(); ++k) {
    different += by_cell[k] == every[k] ? 0 : 1;
    hits += every[k] < 30.0f ? 1 : 0;
  }
  EXPECT_EQ(different, 0u) << "of " << every.size();
  EXPECT_GT(5 * hits, every.size());
  std::printf("%zu walls: %zu rays, %zu of them hits, %zu differ\n", GetParam().walls, every.size(), hits,
              different);
}

INSTANTIATE_TEST_SUITE_P(Walls, WallSearch,
                         ::testing::Values(Case{10, 200, 0.3}, Case{100, 400, 0.3}, Case{1000, 800, 0.3},
                                           Case{10000, 2000, 0.08}, Case{100000, 4000, 0.02}),
                         [](const auto& test) { return std::to_string(test.param.walls); });

}  // namespace
}  // namespace parloc
