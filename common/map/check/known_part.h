// The part of a map that is known, and the map without what lies around it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/map/grid_map.h"

namespace parloc {

/// A rectangle of cells; empty: no cell.
struct CellBox {
  std::int32_t i = 0, j = 0, width = 0, height = 0;  ///< Its lower-left cell and its sides.

  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// The smallest box with every cell that is not unknown. One pass over the cells.
CellBox known_part(const GridMap& map);

/// The cells of `known_part` and `margin` cells around it, as far as the map has them, at their place in the
/// map frame. Outside of a grid is unknown, so nothing else changes. Throws Error{input} if every cell is
/// unknown. Walls are left out.
GridMap cropped(const GridMap& map, std::int32_t margin);

}  // namespace parloc
