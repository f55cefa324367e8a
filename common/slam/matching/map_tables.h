// Which tiles maps in the making have, and where: the tables of all maps cover one span of places, which
// grows.
#pragma once

#include <functional>
#include <vector>

#include "common/slam/matching/tiles.h"

namespace parloc {

/// One particle's map in host memory: the cells of the smallest rectangle of tiles that holds all it has.
struct SlamCells {
  std::int32_t first_i = 0, first_j = 0, width = 0, height = 0;  ///< [cells]
  std::vector<CellWord> cell;                                    ///< Row-major.
  TileSpan span;                                                 ///< What the tables cover.
};

/// Tiles that scans at the poses may touch.
TileSpan reached_tiles(const std::vector<float>& x, const std::vector<float>& y, double reach_m,
                       double resolution_m);
/// A span that holds `span` and everything within `reach_m` of the poses, with room to spare if it must grow.
/// Throws Error{input} for one that no map can have.
TileSpan grown_span(const TileSpan& span, const std::vector<float>& x, const std::vector<float>& y,
                    double reach_m, double resolution_m);
/// What of the tables' places in one span they have in another.
std::vector<std::uint32_t> moved_tables(const std::vector<std::uint32_t>& table, const TileSpan& from,
                                        const TileSpan& to, std::size_t particles);

/// Each tile that the tables name, in the order in which they do first; the empty one apart.
std::vector<std::uint32_t> tiles_named(const std::vector<std::uint32_t>& table);
/// How many tables name each of `tiles` tiles; the empty one counts as named.
std::vector<std::uint32_t> count_references(const std::vector<std::uint32_t>& table, std::size_t tiles);
/// The first `count` tiles without a reference.
std::vector<std::uint32_t> first_free(const std::uint32_t* references, std::size_t count);
/// The cells that a table names; read(ids, to) fetches tiles.
SlamCells gather_cells(const TileSpan& span, const std::uint32_t* table,
                       const std::function<void(const std::vector<std::uint32_t>& ids, Tile* to)>& read);

}  // namespace parloc
