// The skip field promises nothing false, and every exact caster finds the same cell: skipping against cell by
// cell, one ray at a time and as the CPU backend casts them, many at once.
#include "common/map/rays/ray_cast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "common/map/grid_map.h"
#include "common/map/rays/skip_field.h"
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

constexpr std::int32_t kSlopeCounts[] = {kSlopes, kSlopes / 2, 0};

struct Field {
  /// Slopes: 0 for one plane that serves all directions.
  Field(const GridMap& grid, std::int32_t slopes)
      : skip(skip_field(
            blocking_cells(grid, true).data(), grid.width, grid.height,
            slopes == 0 ? 0
                        : static_cast<std::size_t>((grid.width + 2) * (grid.height + 2) * (8 * slopes + 1)),
            2)),
        map{skip.lines.data() + grid.width + 3,
            grid.width,
            grid.height,
            grid.width + 2,
            0.25f,
            4.0f,
            skip.planes,
            {}} {}
  SkipField skip;
  RayMap map;
};

// ---- the table ----------------------------------------------------------------------------------

/// The cells that a ray leaves before it has crossed `lines` lines of its main axis, one by one.
bool free_for(const RayMap& map, const Ray& ray, std::int32_t i, std::int32_t j, std::int32_t lines) {
  const bool steep = (octant_of(ray.dx, ray.dy) & 4) != 0;
  for (std::int32_t crossed = 0; crossed < lines;) {
    if (!map.contains(i, j) || map.skip_at(i, j) == 0) return false;
    const float tx = (static_cast<float>(i + (ray.dx < 0.0f ? 0 : 1)) - ray.u) * ray.inv_dx;
    const float ty = (static_cast<float>(j + (ray.dy < 0.0f ? 0 : 1)) - ray.v) * ray.inv_dy;
    const bool step_x = tx < ty;
    if (step_x)
      i += ray.dx < 0.0f ? -1 : 1;
    else
      j += ray.dy < 0.0f ? -1 : 1;
    crossed += step_x != steep ? 1 : 0;
  }
  return true;
}

TEST(SkipField, KeepsItsPromiseInEverySector) {
  std::mt19937 random(5);
  const GridMap grid = pillars(3);
  for (const std::int32_t slopes : kSlopeCounts) {
    const Field field(grid, slopes);
    double promised = 0.0;
    for (int k = 0; k < 300'000; ++k) {
      const std::int32_t i = static_cast<std::int32_t>(random() % 53),
                         j = static_cast<std::int32_t>(random() % 37);
      if (field.map.skip_at(i, j) == 0) continue;
      const auto fraction = [&] {
        return random() % 5 == 0 ? 0.0f : static_cast<float>(random() % 4096) / 4096.0f;
      };
      const SinCos d = portable_sincos(static_cast<float>(random() % 6284) * 1e-3f);
      const Ray ray =
          make_ray(static_cast<float>(i) + fraction(), static_cast<float>(j) + fraction(), d.cos, d.sin);
      const std::int32_t octant = octant_of(ray.dx, ray.dy);
      const float slope = __builtin_fabsf((octant & 4) != 0 ? ray.dx / ray.dy : ray.dy / ray.dx);
      const std::uint8_t* plane =
          field.map.skip + sector_of(octant, slope, field.map.planes.slopes) * field.map.planes.bytes;
      const std::int32_t lines = plane[j * field.map.stride + i];
      ASSERT_GE(lines, 1);
      promised += lines;
      if (lines > 1) {
        ASSERT_TRUE(free_for(field.map, ray, i, j, lines)) << ray.u << " " << ray.v << " " << lines;
      }
    }
    EXPECT_GT(promised / 300'000, slopes == 0 ? 1.2 : slopes == 2 ? 4.0 : 5.0);  // it promises something
  }
}

TEST(SkipField, IsZeroOnWallsTheRingAndTheTail) {
  const GridMap grid = pillars(4);
  for (const std::int32_t slopes : kSlopeCounts) {
    const Field field(grid, slopes);
    const std::size_t planes = static_cast<std::size_t>(slopes == 0 ? 1 : 8 * slopes + 1), plane = 55 * 39;
    ASSERT_EQ(field.skip.lines.size(), planes * plane + kSkipFieldTail);
    for (std::size_t p = 0; p < planes; ++p) {
      for (std::int32_t j = -1; j <= grid.height; ++j) {
        for (std::int32_t i = -1; i <= grid.width; ++i) {
          const bool inside = i >= 0 && j >= 0 && i < grid.width && j < grid.height;
          const bool blocks = !inside || grid.at(i, j) != Cell::free;
          ASSERT_EQ(field.map.skip[p * plane + static_cast<std::size_t>((j + 1) * 55 + i + 1) - 56] == 0,
                    blocks)
              << i << " " << j;
        }
      }
    }
  }
}

TEST(SkipField, KnowsTheLeastOfAllSectors) {
  const GridMap grid = pillars(6);
  const Field field(grid, kSlopes);
  for (std::int32_t j = 0; j < grid.height; ++j) {
    for (std::int32_t i = 0; i < grid.width; ++i) {
      int least = 255;
      for (std::int32_t s = 0; s < 8 * kSlopes; ++s)
        least = std::min<int>(least, field.map.skip[s * field.map.planes.bytes + j * field.map.stride + i]);
      ASSERT_EQ(field.map.free_lines_at(i, j), least) << i << " " << j;
    }
  }
}

TEST(SkipField, IsTheSameOnAnyNumberOfThreads) {
  const GridMap grid = pillars(7);
  const std::vector<std::uint8_t> blocks = blocking_cells(grid, true);
  const SkipField one = skip_field(blocks.data(), grid.width, grid.height, 1 << 20, 1);
  for (const int threads : {0, 2, 3, 64})
    EXPECT_EQ(skip_field(blocks.data(), grid.width, grid.height, 1 << 20, threads).lines, one.lines)
        << threads;
}

TEST(SkipField, CountsUpTo255Lines) {
  const std::int32_t side = 601;
  const std::vector<std::uint8_t> empty(static_cast<std::size_t>(side * side), 0);
  const SkipField all = skip_field(empty.data(), side, side, 0),
                  each = skip_field(empty.data(), side, side, 64 << 20);
  const std::size_t centre = 301 * 603 + 301;
  EXPECT_EQ(all.lines[centre], 253);            // two less than a distance that is capped at 255
  EXPECT_EQ(each.lines[centre], 255);           // sector 0: to the right
  EXPECT_EQ(each.lines[301 * 603 + 501], 101);  // column 500: 101 lines to the ring
}

TEST(SkipField, SizesThatNoMapHasAreRefused) {
  const std::vector<std::uint8_t> mask(4, 0);
  EXPECT_THROW(skip_field(mask.data(), 4, 0, 0), Error);
  EXPECT_THROW(skip_field(mask.data(), 32768, 1, 0), Error);
}

// ---- the casters --------------------------------------------------------------------------------

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

void expect_same_hit(const RayMap& map, const Ray& ray, float reach_cells, int& hits) {
  const RayHit a = cast_dda(map, ray, reach_cells), b = cast_skip(map, ray, reach_cells);
  ASSERT_EQ(a.hit, b.hit) << ray.u << " " << ray.v << " " << ray.dx << " " << ray.dy;
  hits += a.hit ? 1 : 0;
  if (a.hit) {
    ASSERT_TRUE(a.i == b.i && a.j == b.j) << ray.u << " " << ray.v << " " << ray.dx << " " << ray.dy;
  }
}

TEST(RayCast, SkippingHitsTheCellThatCellByCellHits) {
  std::mt19937 random(11);
  for (const std::int32_t slopes : kSlopeCounts) {
    int hits = 0;
    for (std::uint32_t seed = 1; seed <= 5; ++seed) {
      const Field field(pillars(seed), slopes);
      ASSERT_EQ(field.map.planes.bytes > 0, slopes > 0);
      for (int k = 0; k < 100'000 && !HasFatalFailure(); ++k)
        expect_same_hit(field.map, random_ray(random, field.map), k % 2 == 0 ? 200.0f : 12.3f, hits);
    }
    EXPECT_GT(hits, 100'000);  // both outcomes were seen often
    EXPECT_LT(hits, 400'000);
  }
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
    FilterBackendConfig config{.particles = static_cast<std::int64_t>(poses.x.size()),
                               .sensor = default_sensor(SensorModel::gaussian)};
    config.sensor.caster = caster;
    BeamTable beams;
    BeamCounts counts;
    select_beams(scan, ScanConfig{}, config.sensor, grid.resolution_m, beams, counts);
    const auto backend = make_cpu_filter_backend(config);
    backend->set_map(grid);
    backend->upload(poses);
    backend->set_scan(beams);
    return backend->ray_trace();
  };
  EXPECT_EQ(ranges(RayCaster::skip), ranges(RayCaster::dda));
}

}  // namespace
}  // namespace parloc
