#include "common/search/search_map.h"

#include <algorithm>

#include "common/map/distance_field.h"
#include "common/map/grid_map.h"
#include "common/math/portable.h"

namespace parloc {
namespace {

std::int32_t divided_up(std::int32_t a, std::int32_t b) {
  return (a + b - 1) / b;
}

std::int32_t choose_pool(const GridMap& map, double cell_m) {
  std::int32_t pool = 1;
  while (map.resolution_m * (pool + 0.5) < cell_m) ++pool;  // to the nearest multiple
  const auto cells = [&] { return std::int64_t{divided_up(map.width, pool)} * divided_up(map.height, pool); };
  while (cells() > kMostSearchCells) ++pool;
  return pool;
}

/// Squared distance to the nearest occupied cell, by cell of the map [cells^2].
std::vector<std::uint32_t> squared_distances(const GridMap& map) {
  const std::vector<std::uint8_t> occupied = blocking_cells(map, false);
  const std::size_t width = static_cast<std::size_t>(map.width);
  std::vector<std::uint32_t> squared(map.size());
  column_distances(occupied.data(), squared.data(), map.width, map.height, map.width);
  std::vector<RowParabola> scratch(width);
  for (std::size_t j = 0; j < static_cast<std::size_t>(map.height); ++j)
    row_squared_distances(squared.data() + j * width, map.width, scratch.data());
  return squared;
}

/// Value of a cell by squared distance; what is beyond the table is worth nothing.
std::vector<std::uint8_t> value_table(double resolution_m, double sigma_m) {
  std::vector<std::uint8_t> table;
  for (double squared = 0.0;; squared += 1.0) {
    const double exponent = -0.5 * squared * resolution_m * resolution_m / (sigma_m * sigma_m);
    const float value =
        round_even(static_cast<float>(kMostValue) * portable_exp(static_cast<float>(exponent)));
    if (value < 1.0f) return table;
    table.push_back(static_cast<std::uint8_t>(value));
  }
}

/// The values with room before them for windows that begin off the map.
struct Windows {
  std::int32_t width, height;  // with the room
  std::vector<std::uint8_t> value;

  std::uint8_t& at(std::int32_t x, std::int32_t y) {
    return value[static_cast<std::size_t>(y + kBlockCells) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(x + kBlockCells)];
  }
  /// From windows of `side` cells to windows of twice that.
  void double_windows(std::int32_t side) {
    for (std::int32_t y = -kBlockCells; y < height - kBlockCells; ++y) {
      const bool last_y = y + side >= height - kBlockCells;
      for (std::int32_t x = -kBlockCells; x < width - kBlockCells; ++x) {
        const bool last_x = x + side >= width - kBlockCells;
        std::uint8_t most = at(x, y);
        if (!last_x) most = std::max(most, at(x + side, y));
        if (!last_y) most = std::max(most, at(x, y + side));
        if (!last_x && !last_y) most = std::max(most, at(x + side, y + side));
        at(x, y) = most;  // what is read later lies ahead
      }
    }
  }
};

Windows pooled_values(const GridMap& map, const SearchMap& s, double sigma_m) {
  Windows w{s.shape.width + kBlockCells, s.shape.height + kBlockCells, {}};
  w.value.assign(static_cast<std::size_t>(w.width) * static_cast<std::size_t>(w.height), 0);
  const std::vector<std::uint8_t> table = value_table(map.resolution_m, sigma_m);
  const std::vector<std::uint32_t> squared = squared_distances(map);
  std::size_t at = 0;
  for (std::int32_t j = 0; j < map.height; ++j)
    for (std::int32_t i = 0; i < map.width; ++i, ++at) {
      if (squared[at] >= table.size()) continue;
      std::uint8_t& most = w.at(i / s.pool, j / s.pool);
      most = std::max(most, table[squared[at]]);
    }
  return w;
}

PlaneStore plain_cells(Windows& w, SearchMap& s) {
  SearchPlane& shape = s.shape.cells;
  shape = {nullptr, s.shape.width, s.shape.height, s.shape.width + kBlockCells};
  PlaneStore store;
  store.first = static_cast<std::size_t>(kBlockCells + kBlockCells * shape.stride);
  store.bytes.assign(
      2 * store.first + static_cast<std::size_t>(shape.height) * static_cast<std::size_t>(shape.stride), 0);
  for (std::int32_t y = 0; y < shape.height; ++y)
    std::copy_n(
        &w.at(0, y), shape.width,
        store.bytes.begin() + static_cast<std::ptrdiff_t>(store.first) + std::int64_t{y} * shape.stride);
  return store;
}

PlaneStore split_by_phase(Windows& w, SearchMap& s) {
  constexpr std::int32_t mask = kBlockCells - 1;
  SearchPlane& shape = s.shape.windows;
  shape.width = ((s.shape.width - 1) >> kBlockBits) + 2;
  shape.height = ((s.shape.height - 1) >> kBlockBits) + 2;
  shape.stride = shape.width + kSweepLanes;
  s.shape.plane = std::int64_t{shape.stride} * (shape.height + 2);
  PlaneStore store;
  store.first = static_cast<std::size_t>(kSweepLanes + shape.stride);
  store.bytes.assign(static_cast<std::size_t>(2 * kSweepLanes + s.shape.plane * kBlockPoses), 0);
  for (std::int32_t y = -kBlockCells; y < s.shape.height; ++y)
    for (std::int32_t x = -kBlockCells; x < s.shape.width; ++x) {
      const std::int64_t plane = ((y & mask) << kBlockBits) + (x & mask);
      const std::int64_t entry = std::int64_t{(y >> kBlockBits) + 1} * shape.stride + (x >> kBlockBits) + 1;
      store.bytes[store.first + static_cast<std::size_t>(plane * s.shape.plane + entry)] = w.at(x, y);
    }
  return store;
}

std::vector<std::uint8_t> pooled_free(const GridMap& map, const SearchMap& s) {
  std::vector<std::int32_t> count(
      static_cast<std::size_t>(s.shape.width) * static_cast<std::size_t>(s.shape.height), 0);
  std::size_t at = 0;
  for (std::int32_t j = 0; j < map.height; ++j)
    for (std::int32_t i = 0; i < map.width; ++i, ++at)
      if (map.cells[at] == Cell::free)
        ++count[static_cast<std::size_t>(j / s.pool) * static_cast<std::size_t>(s.shape.width) +
                static_cast<std::size_t>(i / s.pool)];
  // Half of it must be free. Where no cell has as much, any part will do: a map that a robot can be on can be
  // searched.
  const std::int32_t half = (s.pool * s.pool + 1) / 2, most = *std::max_element(count.begin(), count.end());
  const std::int32_t enough = most >= half ? half : 1;
  std::vector<std::uint8_t> free(count.size());
  for (std::size_t c = 0; c < free.size(); ++c) free[c] = count[c] >= enough ? 1 : 0;
  return free;
}

std::vector<std::uint8_t> blocks_with_any(const std::vector<std::uint8_t>& cells, const SearchGrid& g) {
  const auto across = static_cast<std::size_t>(g.blocks_x());
  std::vector<std::uint8_t> blocks(across * static_cast<std::size_t>(g.blocks_y()));
  std::size_t at = 0;
  for (std::int32_t j = 0; j < g.height; ++j)
    for (std::int32_t i = 0; i < g.width; ++i, ++at)
      if (cells[at] != 0)
        blocks[static_cast<std::size_t>(j >> kBlockBits) * across +
               static_cast<std::size_t>(i >> kBlockBits)] = 1;
  return blocks;
}

}  // namespace

SearchGrid SearchMap::view() const {
  SearchGrid g = shape;
  g.cells.first = cells.bytes.data() + cells.first;
  g.windows.first = windows.bytes.data() + windows.first;
  g.free_cells = free_cells.data();
  g.free_blocks = free_blocks.data();
  return g;
}

SearchMap make_search_map(const GridMap& map, const SearchConfig& config) {
  SearchMap s;
  s.pool = choose_pool(map, config.cell_m);
  s.cell_m = map.resolution_m * s.pool;
  s.shape.width = divided_up(map.width, s.pool);
  s.shape.height = divided_up(map.height, s.pool);
  Windows windows = pooled_values(map, s, config.sigma_m);
  s.cells = plain_cells(windows, s);
  for (std::int32_t side = 1; side < kBlockCells; side *= 2) windows.double_windows(side);
  s.windows = split_by_phase(windows, s);
  s.free_cells = pooled_free(map, s);
  s.free_blocks = blocks_with_any(s.free_cells, s.shape);
  s.free_count = static_cast<std::size_t>(std::count(s.free_cells.begin(), s.free_cells.end(), 1));
  return s;
}

}  // namespace parloc
