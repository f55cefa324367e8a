// The maps of all particles: tiles of 32 x 32 cells in one pool, shared between particles until one of them
// writes (SPEC 9.5). A particle has a table that names the tile of each place.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/slam/matching/cell.h"

namespace parloc {

constexpr std::int32_t kTileCells = 32;
constexpr int kTileShift = 5;

struct Tile {
  CellWord cell[kTileCells * kTileCells];  ///< Row-major.
  std::uint32_t occupied[kTileCells];      ///< is_occupied of each row's cells, a bit each.
};

/// The bits of all rows, from the cells.
inline void set_occupied(Tile& tile) {
  for (std::int32_t j = 0; j < kTileCells; ++j) {
    tile.occupied[j] = 0;
    for (std::int32_t i = 0; i < kTileCells; ++i)
      tile.occupied[j] |= is_occupied(tile.cell[j * kTileCells + i]) ? 1u << i : 0u;
  }
}

/// Place of a cell in its tile.
PARLOC_HD std::int32_t cell_in_tile(std::int32_t i, std::int32_t j) {
  return (j & (kTileCells - 1)) * kTileCells + (i & (kTileCells - 1));
}

/// Tile 0 is empty, is never written, and stands for all that is unknown.
constexpr std::uint32_t kNoTile = 0;

/// Tiles in chunks, so that the pool grows without moving.
constexpr int kChunkShift = 9;
constexpr std::uint32_t kChunkTiles = 1u << kChunkShift;
struct TilePool {
  Tile* const* chunk = nullptr;
  PARLOC_HD Tile& at(std::uint32_t id) const { return chunk[id >> kChunkShift][id & (kChunkTiles - 1)]; }
};

/// Which tiles the tables cover: from tile (first_i, first_j), row-major.
struct TileSpan {
  std::int32_t first_i = 0, first_j = 0, width = 0, height = 0;

  PARLOC_HD std::size_t size() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  /// Of a cell's tile; size() beyond the span.
  PARLOC_HD std::size_t place(std::int32_t cell_i, std::int32_t cell_j) const {
    const std::int32_t i = (cell_i >> kTileShift) - first_i, j = (cell_j >> kTileShift) - first_j;
    const bool inside = i >= 0 && j >= 0 && i < width && j < height;
    return inside
               ? static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)
               : size();
  }
};

/// One particle's map. Cells are counted from the map frame's origin, negative ones included.
struct TileMap {
  TileSpan span;
  const std::uint32_t* table = nullptr;  ///< [span.size()]
  TilePool pool;

  PARLOC_HD const Tile& tile(std::int32_t i, std::int32_t j) const {
    const std::size_t at = span.place(i, j);
    return pool.at(at < span.size() ? table[at] : kNoTile);
  }
  PARLOC_HD CellWord cell(std::int32_t i, std::int32_t j) const {
    return tile(i, j).cell[cell_in_tile(i, j)];
  }
  /// Bits 0 to 2: whether the cells i - 1 to i + 1 of row j are occupied.
  PARLOC_HD std::uint32_t occupied_row(std::int32_t i, std::int32_t j) const {
    const std::int32_t in_i = i & (kTileCells - 1), in_j = j & (kTileCells - 1);
    const std::uint32_t row = tile(i, j).occupied[in_j];
    if (in_i == 0) return ((row << 1) & 6u) | (tile(i - 1, j).occupied[in_j] >> 31);
    if (in_i == kTileCells - 1) return (row >> 30) | ((tile(i + 1, j).occupied[in_j] & 1u) << 2);
    return (row >> (in_i - 1)) & 7u;
  }
};

/// Several maps, such as those of all particles, in the backend's memory.
struct SlamMaps {
  TileSpan span;
  std::uint32_t* table = nullptr;  ///< [N][span.size()]
  TilePool pool;

  PARLOC_HD TileMap of(std::size_t particle) const { return {span, table + particle * span.size(), pool}; }
};

}  // namespace parloc
