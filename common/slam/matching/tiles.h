// The maps of all particles: tiles of 32 x 32 cells in one pool, shared between particles until one of them
// writes (SPEC 9.5). A particle has a table that names the tile of each place.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/math/host_device.h"
#include "common/math/portable.h"

namespace parloc {

/// A cell of a map in the making: how many beams came to it, how many of them ended there, and where. One
/// 64-bit word, so that a beam is counted by one addition; integers, so that the order of beams does not
/// matter (SPEC 9.5).
///
/// From the low bit: visits (16 bits), hits (12), sums of the end points' places in the cell, x and y
/// (18 each) [1/128 cell].
using CellWord = std::uint64_t;

constexpr int kHitShift = 16, kSumXShift = 28, kSumYShift = 46;
constexpr std::uint32_t kPlacesPerCell = 128;
/// Beams of one scan.
constexpr std::size_t kMostDrawnBeams = 1024;
/// Fields are halved from here on, and a scan adds at most kMostDrawnBeams to each: none runs over.
constexpr std::uint32_t kMostHits = 1024, kMostVisits = 32768;

PARLOC_HD std::uint32_t visits_of(CellWord w) {
  return static_cast<std::uint32_t>(w & 0xffffu);
}
PARLOC_HD std::uint32_t hits_of(CellWord w) {
  return (static_cast<std::uint32_t>(w) >> kHitShift) & 0xfffu;  // in the low half of the word
}
PARLOC_HD std::uint32_t sum_x_of(CellWord w) {
  return static_cast<std::uint32_t>((w >> kSumXShift) & 0x3ffffu);
}
PARLOC_HD std::uint32_t sum_y_of(CellWord w) {
  return static_cast<std::uint32_t>(w >> kSumYShift);
}
PARLOC_HD CellWord cell_word(std::uint32_t visits, std::uint32_t hits, std::uint32_t x, std::uint32_t y) {
  return CellWord{visits} | (CellWord{hits} << kHitShift) | (CellWord{x} << kSumXShift) |
         (CellWord{y} << kSumYShift);
}

/// What a beam adds to a cell that it passes.
constexpr CellWord kPassed = 1;

/// What a beam adds to the cell where it ends; (x, y): where in the cell, in [0, 1).
PARLOC_HD CellWord ended_at(float x, float y) {
  const float last = static_cast<float>(kPlacesPerCell - 1);
  const float qx = max_of(min_of(floor_of(x * static_cast<float>(kPlacesPerCell)), last), 0.0f);
  const float qy = max_of(min_of(floor_of(y * static_cast<float>(kPlacesPerCell)), last), 0.0f);
  return cell_word(1, 1, static_cast<std::uint32_t>(qx), static_cast<std::uint32_t>(qy));
}

/// Mean place of the end points, in cells from the cell's corner. There must be hits.
struct MeanPlace {
  float x, y;
};
PARLOC_HD MeanPlace mean_place(CellWord w) {
  constexpr float kMiddle =
      0.5f / static_cast<float>(kPlacesPerCell);  // of the places that a sum counts as one
  const float per_hit = 1.0f / (static_cast<float>(hits_of(w)) * static_cast<float>(kPlacesPerCell));
  return {fused(static_cast<float>(sum_x_of(w)), per_hit, kMiddle),
          fused(static_cast<float>(sum_y_of(w)), per_hit, kMiddle)};
}

/// A wall for the scan matcher: more than a tenth of the beams that came to the cell ended there.
PARLOC_HD bool is_occupied(CellWord w) {
  return 10 * hits_of(w) > visits_of(w);
}

/// All fields halved once they are large: old evidence counts less, and nothing runs over.
PARLOC_HD CellWord aged(CellWord w) {
  if (hits_of(w) < kMostHits && visits_of(w) < kMostVisits) return w;
  return cell_word(visits_of(w) / 2, hits_of(w) / 2, sum_x_of(w) / 2, sum_y_of(w) / 2);
}

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

  /// In 32 bits: no map has more cells along a side than kMaxMapSide.
  PARLOC_HD std::size_t size() const {
    return static_cast<std::uint32_t>(width) * static_cast<std::uint32_t>(height);
  }
  /// Of a cell's tile; size() beyond the span.
  PARLOC_HD std::size_t place(std::int32_t cell_i, std::int32_t cell_j) const {
    const std::int32_t i = (cell_i >> kTileShift) - first_i, j = (cell_j >> kTileShift) - first_j;
    const bool inside = i >= 0 && j >= 0 && i < width && j < height;
    return inside ? static_cast<std::uint32_t>(j) * static_cast<std::uint32_t>(width) +
                        static_cast<std::uint32_t>(i)
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
