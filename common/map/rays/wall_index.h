// Which walls of a map pass which cells, so that a ray need not be tried against all of them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"
#include "common/map/rays/wall_cast.h"

namespace parloc {

struct WallIndex {
  std::vector<RayWall> walls;  ///< Those of the map, in its order [cells].
  std::vector<std::uint32_t>
      ids;  ///< Walls cell by cell; those of cell c are ids[first[c]] to ids[first[c + 1] - 1].
  std::vector<std::uint32_t> first;  ///< [width * height + 1]
  std::vector<std::uint8_t> blocks;  ///< [width * height] 1 where a cell has walls: there a ray has to look.

  Walls view() const {
    return {walls.data(), ids.data(), first.data(), static_cast<std::uint32_t>(walls.size())};
  }
};

/// A wall is listed in every cell that it comes near to, by more than a float32 ray can err: that makes the
/// search exact (cast_walls). Throws Error{internal} if a wall is less than a cell inside the grid or there
/// are too many entries. Serial, linear in the walls' length; the same on every machine.
WallIndex index_walls(const GridMap& map);

}  // namespace parloc
