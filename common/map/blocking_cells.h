// Which cells end a ray, and which are the walls that a distance is measured to.
#pragma once

#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"

namespace parloc {

/// 1 for an occupied cell, and for an unknown one if unknown_blocks; else 0.
inline std::vector<std::uint8_t> blocking_cells(const GridMap& map, bool unknown_blocks) {
  std::vector<std::uint8_t> blocks(map.size());
  for (std::size_t c = 0; c < blocks.size(); ++c)
    blocks[c] = map.cells[c] == Cell::occupied || (unknown_blocks && map.cells[c] == Cell::unknown) ? 1 : 0;
  return blocks;
}

}  // namespace parloc
