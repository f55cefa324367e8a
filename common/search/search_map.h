// A map made ready for the global search: once per map, for every backend.
#pragma once

#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"
#include "common/search/lattice.h"
#include "common/search/search_config.h"

namespace parloc {

/// Rows of bytes, with the zeros around them.
struct PlaneStore {
  std::vector<std::uint8_t> bytes;
  std::size_t first = 0;  ///< Where entry (0, 0) is.
};

struct SearchMap {
  std::int32_t pool = 1;  ///< Cells of the map along a side of a search cell.
  double cell_m = 0.0;
  SearchGrid shape;  ///< Without its pointers.
  PlaneStore cells, windows;
  std::vector<std::uint8_t> free_cells, free_blocks;
  std::size_t free_count = 0;  ///< Free cells.

  /// Of the arrays here, for backends that work in host memory.
  SearchGrid view() const;
};

/// A search cell is free if at least half of its cells are, and worth what the best of them is. Cells are put
/// together until they are as large as asked for, and there are at most kMostSearchCells.
SearchMap make_search_map(const GridMap& map, const SearchConfig& config);

constexpr std::int64_t kMostSearchCells = std::int64_t{1} << 26;

}  // namespace parloc
