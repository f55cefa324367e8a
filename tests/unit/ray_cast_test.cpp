// Every exact caster finds the same cell: skipping against cell by cell, one ray at a time and as the CPU
// backend casts them, many at once.
#include "common/map/ray_cast.h"

#include <gtest/gtest.h>

#include <random>

#include "common/filter/backend.h"
#include "common/map/blocking_cells.h"
#include "common/map/skip_field.h"
#include "common/model/beams.h"

namespace parloc {
namespace {

/// Cells of 25 cm, so that a cell's edge is an exact number of metres; one cell in 50 is a wall, none is on
/// the border, so that rays also leave the grid.
GridMap pillars(std::uint32_t seed) {
  std::vector<std::string> rows(37, std::string(53, '.'));
  std::mt19937 random(seed);
  for (std::size_t j = 1; j + 1 < rows.size(); ++j)
    for (std::size_t i = 1; i + 1 < rows[j].size(); ++i)
      if (random() % 50 == 0) rows[j][i] = '#';
  return grid_from_text(rows, 0.25);
}

struct Field {
  explicit Field(const GridMap& grid)
      : skip(skip_field(blocking_cells(grid, true).data(), grid.width, grid.height)),
        map{skip.data() + grid.width + 3, grid.width, grid.height, grid.width + 2, 0.25f, 4.0f} {}
  std::vector<std::uint8_t> skip;
  RayMap map;
};

/// Anywhere, on cells' edges and corners, and outside of the grid; any direction, and those along an axis or
/// a diagonal.
Ray random_ray(std::mt19937& random, const RayMap& map) {
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random()) / 4294967296.0f;
  };
  const auto start = [&](std::int32_t size) {
    const float anywhere = uniform(-5.0f, static_cast<float>(size) + 5.0f);
    return random() % 3 == 0 ? floor_of(anywhere) : anywhere;
  };
  const float angle =
      random() % 4 == 0 ? 0.78539816339f * static_cast<float>(random() % 8) : uniform(-3.2f, 3.2f);
  const SinCos direction = portable_sincos(angle);
  const float u = start(map.width), v = start(map.height);
  return make_ray(u, v, direction.cos, direction.sin);
}

TEST(RayCast, SkippingHitsTheCellThatCellByCellHits) {
  std::mt19937 random(11);
  int hits = 0;
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const Field field(pillars(seed));
    for (int k = 0; k < 100'000; ++k) {
      const Ray ray = random_ray(random, field.map);
      const float reach_cells = k % 2 == 0 ? 200.0f : 12.3f;
      const RayHit a = cast_dda(field.map, ray, reach_cells), b = cast_skip(field.map, ray, reach_cells);
      ASSERT_EQ(a.hit, b.hit) << ray.u << " " << ray.v << " " << ray.dx << " " << ray.dy;
      hits += a.hit ? 1 : 0;
      if (!a.hit) continue;
      ASSERT_TRUE(a.i == b.i && a.j == b.j) << ray.u << " " << ray.v << " " << ray.dx << " " << ray.dy;
    }
  }
  EXPECT_GT(hits, 100'000);  // both outcomes were seen often
  EXPECT_LT(hits, 400'000);
}

TEST(RayCast, ManyAtOnceGiveTheRangesOfOneByOne) {
  const GridMap grid = pillars(7);
  ParticleSet poses;
  std::mt19937 random(12);
  for (int k = 0; k < 4000; ++k) {  // half of them on the corners of cells
    const float x = -1.0f + 16.0f * static_cast<float>(random()) / 4294967296.0f;
    const float y = -1.0f + 12.0f * static_cast<float>(random()) / 4294967296.0f;
    poses.x.push_back(k % 2 == 0 ? x : 0.25f * floor_of(4.0f * x));
    poses.y.push_back(k % 2 == 0 ? y : 0.25f * floor_of(4.0f * y));
    poses.theta.push_back(k % 3 == 0 ? 0.0f : -3.1f + 0.001f * static_cast<float>(k % 6200));
    poses.log_weight.push_back(0.0f);
  }
  Scan scan;
  scan.angle_step_rad = 0.78539816339 / 9.0;  // every ninth beam lies along an axis or a diagonal
  scan.angle_min_rad = -36 * scan.angle_step_rad;
  scan.range_max_m = 9.0;
  scan.ranges_m.assign(73, 1.0f);
  const auto ranges = [&](RayCaster caster) {
    BackendConfig config;
    config.particles = static_cast<std::int64_t>(poses.x.size());
    config.sensor = default_sensor(SensorModel::gaussian);
    config.sensor.caster = caster;
    BeamTable beams;
    BeamCounts counts;
    select_beams(scan, ScanConfig{}, config.sensor, grid.resolution_m, beams, counts);
    const auto backend = make_cpu_backend(config);
    backend->set_map(grid);
    backend->upload(poses);
    backend->set_scan(beams);
    return backend->ray_trace();
  };
  EXPECT_EQ(ranges(RayCaster::skip), ranges(RayCaster::dda));
}

}  // namespace
}  // namespace parloc
