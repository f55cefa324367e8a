// Cells -> walls.
#pragma once

#include <cstddef>
#include <vector>

#include "common/map/grid_map.h"

namespace parloc {

/// Chains of walls, each wall beginning where the one before it ends, or a new chain.
struct TracedWalls {
  std::vector<GridWall> walls;  ///< In the frame of the grid.
  std::size_t faces = 0;        ///< Straight runs of cell faces, before they were simplified.
  double error_m = 0.0;         ///< What simplifying cost, measured: at most what was allowed.
};

/// The faces between blocking cells and others inside the grid, straight runs of them merged: what a ray in
/// the grid ends at. Blocking cells that meet at a corner only are taken as one thing. A face on the rim of
/// the grid is none: what is outside is not known. With `max_error_m` above 0, neighbouring walls are
/// replaced by longer ones, no point of the old being farther than that from the new, nor the reverse
/// (Douglas and Peucker's method on every chain); a small thing becomes a line, and never nothing. Walls that
/// are nearer to each other than twice that may cross. Throws Error{usage} if it is negative or not finite.
TracedWalls trace_walls(const GridMap& map, double max_error_m = 0.0, bool unknown_blocks = false);

}  // namespace parloc
