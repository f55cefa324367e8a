// Walls -> cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "common/map/grid_map.h"

namespace parloc {

/// Calls visit(i, j) for every cell of the grid that the segment touches, be it at a corner (its supercover),
/// row by row. A cell that it misses by no more than two millionths of a cell may count as touched.
template <class Visit>
void for_each_touched_cell(const GridMap& map, const GridWall& wall, Visit&& visit) {
  constexpr double kNear = 1e-6;  // covers the rounding below
  const double scale = 1.0 / map.resolution_m;
  double ax = wall.ax * scale, ay = wall.ay * scale, bx = wall.bx * scale, by = wall.by * scale;
  if (ay > by) std::swap(ax, bx), std::swap(ay, by);
  const auto x_at = [&](double y) { return by > ay ? ax + (y - ay) / (by - ay) * (bx - ax) : ax; };
  // Cell k is [k, k + 1]: the interval from low to high touches ceil(low) - 1 to floor(high).
  const auto first = [](double low) { return std::max(0.0, std::ceil(low - kNear) - 1.0); };
  const auto last = [](double high, std::int32_t cells) {
    return std::min(cells - 1.0, std::floor(high + kNear));
  };
  const auto end_j = static_cast<std::int32_t>(last(by, map.height));
  for (auto j = static_cast<std::int32_t>(first(ay)); j <= end_j; ++j) {
    double low = x_at(std::clamp(j - kNear, ay, by)), high = x_at(std::clamp(j + 1 + kNear, ay, by));
    if (ay == by) high = bx;
    if (low > high) std::swap(low, high);
    const auto end_i = static_cast<std::int32_t>(last(high, map.width));
    for (auto i = static_cast<std::int32_t>(first(low)); i <= end_i; ++i) visit(i, j);
  }
}

/// Fills map.cells from map.walls: occupied where a wall passes, else free or unknown. If the walls enclose
/// an area that reaches as far as they do on every side (to a twentieth, or 5 cells) and fills a quarter of
/// their bounding box, then what lies outside of it is unknown; else, as in an open court with a pillar,
/// nothing is. Returns whether they do. The outermost cells of the grid must be clear of walls.
bool rasterise_walls(GridMap& map);

/// The largest distance of an occupied cell's centre from the nearest wall [m]: what is lost by taking the
/// cells for the walls. At most half a cell's diagonal after rasterise_walls().
double raster_error_m(const GridMap& map);

}  // namespace parloc
