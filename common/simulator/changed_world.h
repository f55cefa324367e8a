// A world that is no longer as its map has it: furniture moved, doors closed and opened, another scale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"

namespace parloc {

/// By cells of the map (index into GridMap::cells), ascending.
struct WorldChange {
  std::vector<std::size_t> removed;  ///< Occupied on the map, free in the world.
  std::vector<std::size_t> added;    ///< Free on the map, occupied in the world.
};

/// 1 for the cells of the map that are nearer than `clearance_m` to the path, along either axis.
std::vector<std::uint8_t> cells_near_path(const GridMap& map, const WaypointPath& path, double clearance_m);

/// Takes away and puts down connected pieces of 0.3 to 1.5 m until each of the two is half of `share` of the
/// map's occupied cells, or a little more. What is taken away is furniture first (what is less than 3 m
/// across), then walls; what is put down keeps `clearance_m` from the path. Fewer are put down where there is
/// no room. Equal arguments give equal changes on every machine.
WorldChange move_furniture(const GridMap& map, const WaypointPath& path, double clearance_m, double share,
                           std::uint64_t seed);

/// A gap of 0.6 to 1.4 m in a wall of at most 0.35 m that goes on for 0.3 m and more on both sides.
struct Opening {
  std::vector<std::size_t> cells;
};
std::vector<Opening> find_openings(const GridMap& map);

/// Closes openings that the path keeps `clearance_m` away from, and breaks gaps of 0.9 m through walls of at
/// most 0.4 m between free cells: `share` of the number of openings each, as far as there are such places.
/// Equal arguments give equal changes on every machine.
WorldChange change_doors(const GridMap& map, const WaypointPath& path, double clearance_m, double share,
                         std::uint64_t seed);

/// The world as it is then. `world` is what `map` shows, in cells as large or smaller, or the map itself;
/// both without segments as walls.
GridMap changed_world(const GridMap& world, const GridMap& map, const WorldChange& change);

/// Where a point of the map is in a world that is `scale` times as large, about the grid's corner.
Pose scaled_about_grid(const Pose& pose, const Pose& T_map_grid, double scale);

}  // namespace parloc
