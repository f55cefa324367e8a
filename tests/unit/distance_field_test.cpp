// The exact distance field (SPEC 7.1), against brute force.
#include <gtest/gtest.h>

#include <random>

#include "common/error.h"
#include "common/map/distance_field.h"
#include "cuda/stages.h"  // its kernels, run on the host
#include "tests/unit/map_t1.h"
#include "tests/unit/measured_field.h"

namespace parloc {
namespace {

using Mask = std::vector<std::uint8_t>;
using DistanceField = std::vector<std::uint32_t>;

struct Map {
  std::int32_t width, height;
  Mask mask;
  std::uint8_t at(std::int32_t i, std::int32_t j) const {
    return mask[static_cast<std::size_t>(j * width + i)];
  }
};

Map random_map(std::int32_t width, std::int32_t height, double density, std::uint32_t seed) {
  std::mt19937 random(seed);
  Map map{width, height, Mask(static_cast<std::size_t>(width * height))};
  for (auto& cell : map.mask) cell = random() < density * 4294967296.0 ? std::uint8_t{7} : std::uint8_t{0};
  return map;
}

DistanceField brute_force(const Map& map) {
  DistanceField field(map.mask.size(), kNoObstacle);
  for (std::int32_t j = 0; j < map.height; ++j) {
    for (std::int32_t i = 0; i < map.width; ++i) {
      std::uint32_t& least = field[static_cast<std::size_t>(j * map.width + i)];
      for (std::int32_t b = 0; b < map.height; ++b) {
        for (std::int32_t a = 0; a < map.width; ++a) {
          if (map.at(a, b) == 0) continue;
          least = std::min(least, static_cast<std::uint32_t>((a - i) * (a - i) + (b - j) * (b - j)));
        }
      }
    }
  }
  return field;
}

DistanceField field_of(const Map& map, int threads) {
  return test::squared_distance_field(map.mask.data(), map.width, map.height, threads);
}

/// Sizes around the 64-column strips, thin ones, and densities from nearly empty to nearly full.
std::vector<Map> random_maps() {
  std::vector<Map> maps;
  std::uint32_t seed = 1;
  const std::vector<std::pair<int, int>> sizes{{37, 53}, {64, 20}, {65, 21}, {130, 9},
                                               {1, 40},  {40, 1},  {1, 1},   {2, 2}};
  for (const auto& [width, height] : sizes) {
    for (const double density : {0.0, 0.002, 0.02, 0.3, 0.98}) {
      maps.push_back(random_map(width, height, density, seed++));
    }
  }
  return maps;
}

TEST(DistanceField, TestMapT1) {
  const GridMap map = test::map_t1();
  Mask mask;
  for (const Cell c : map.cells) mask.push_back(c == Cell::occupied ? 1 : 0);
  const DistanceField expected{
      0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  // j = 0
      0, 1, 1, 1, 1, 1, 1, 1, 1, 0,  //
      0, 1, 1, 0, 1, 4, 4, 4, 1, 0,  //
      0, 1, 2, 1, 2, 2, 1, 2, 1, 0,  //
      0, 1, 4, 4, 4, 1, 0, 1, 1, 0,  //
      0, 1, 4, 4, 4, 2, 1, 2, 1, 0,  //
      0, 1, 1, 1, 1, 1, 1, 1, 1, 0,  //
      0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
  };
  EXPECT_EQ(test::squared_distance_field(mask.data(), map.width, map.height, 1), expected);
}

TEST(DistanceField, EqualsBruteForce) {
  for (const Map& map : random_maps()) {
    EXPECT_EQ(field_of(map, 1), brute_force(map)) << map.width << " x " << map.height;
  }
}

TEST(DistanceField, KernelBodiesOnTheHostEqualTheOpenMpTwin) {
  cuda_on_host::Queue queue(0);
  std::vector<Map> maps = random_maps();
  maps.push_back(random_map(600, 300, 0.001, 99));  // more rows than threads in a block
  for (const Map& map : maps) {
    DistanceField field(map.mask.size(), 12345);
    cuda_on_host::FilterStages::squared_distance_field(map.mask.data(), map.width, map.height, field.data(),
                                                       queue);
    EXPECT_EQ(field, field_of(map, 1)) << map.width << " x " << map.height;
  }
}

TEST(DistanceField, AnyNumberOfThreadsGivesTheSame) {
  for (const Map& map :
       {random_map(500, 300, 0.001, 99), random_map(63, 2, 0.1, 98), random_map(1, 1, 1.0, 97)}) {
    const DistanceField one = field_of(map, 1);
    EXPECT_EQ(field_of(map, 2), one);
    EXPECT_EQ(field_of(map, 4), one);
  }
}

TEST(DistanceField, WithoutSourcesThereIsNoDistance) {
  const Map map = random_map(70, 5, 0.0, 1);
  EXPECT_EQ(field_of(map, 2), DistanceField(350, kNoObstacle));
}

// The longest sides: every term of the envelope is at its largest, 2 * 32766^2, and must not overflow.
TEST(DistanceField, TheLongestSidesDoNotOverflow) {
  const std::uint32_t last = 32766;
  for (const bool wide : {true, false}) {
    Mask mask(32767, 0);
    mask.front() = 1;
    const DistanceField field =
        test::squared_distance_field(mask.data(), wide ? 32767 : 1, wide ? 1 : 32767, 1);
    EXPECT_EQ(field.back(), last * last);
    EXPECT_EQ(field[1], 1u);
  }
  // One row at the largest height: sources 32766 cells above at both ends, and one on the row itself.
  std::vector<std::uint32_t> row(32767, last);
  row[0] = 0;
  std::vector<RowParabola> scratch(row.size());
  row_squared_distances(row.data(), 32767, scratch.data());
  EXPECT_EQ(row[0], 0u);
  EXPECT_EQ(row[last], last * last);  // straight up: as near as along the row
  EXPECT_EQ(row[10000], 10000u * 10000u);
}

TEST(DistanceField, SizesThatNoMapHasAreRefused) {
  const Mask mask(4, 0);
  EXPECT_THROW(test::squared_distance_field(mask.data(), 0, 4, 1), Error);
  EXPECT_THROW(test::squared_distance_field(mask.data(), 4, 40000, 1), Error);
  EXPECT_THROW(test::squared_distance_field(mask.data(), 2, 2, 0), Error);
}

}  // namespace
}  // namespace parloc
