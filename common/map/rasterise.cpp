#include "common/map/rasterise.h"

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace parloc {
namespace {

/// Turns the free cells that are connected to cell (0, 0) by their sides into unknown ones, a run of a row at
/// a time.
void flood_outside(GridMap& map) {
  const auto cell = [&](std::int32_t i, std::int32_t j) -> Cell& { return map.cells[map.index(i, j)]; };
  std::vector<std::pair<std::int32_t, std::int32_t>> starts{{0, 0}};
  while (!starts.empty()) {
    const auto [start_i, j] = starts.back();
    starts.pop_back();
    if (cell(start_i, j) != Cell::free) continue;
    std::int32_t begin = start_i, end = start_i;
    while (begin > 0 && cell(begin - 1, j) == Cell::free) --begin;
    while (end < map.width && cell(end, j) == Cell::free) ++end;
    for (std::int32_t i = begin; i < end; ++i) cell(i, j) = Cell::unknown;
    for (const std::int32_t beside : {j - 1, j + 1}) {
      if (beside < 0 || beside >= map.height) continue;
      for (std::int32_t i = begin; i < end; ++i) {  // one start for each run beside this one
        if (cell(i, beside) == Cell::free && (i == begin || cell(i - 1, beside) != Cell::free))
          starts.emplace_back(i, beside);
      }
    }
  }
}

struct CellBox {
  std::int32_t low_i, high_i = -1, low_j, high_j = -1;
  double cells = 0.0;
};

CellBox box_of(const GridMap& map, Cell kind) {
  CellBox box{map.width, -1, map.height, -1, 0.0};
  for (std::int32_t j = 0; j < map.height; ++j) {
    for (std::int32_t i = 0; i < map.width; ++i) {
      if (map.at(i, j) != kind) continue;
      box.low_i = std::min(box.low_i, i), box.high_i = std::max(box.high_i, i);
      box.low_j = std::min(box.low_j, j), box.high_j = std::max(box.high_j, j);
      box.cells += 1.0;
    }
  }
  return box;
}

/// Whether the free cells, all of which are enclosed, are those of a ring around everything else. (In the tip
/// of a corner there are only cells with walls.)
bool fills(const CellBox& enclosed, const CellBox& walls) {
  const std::int32_t width = walls.high_i - walls.low_i + 1, height = walls.high_j - walls.low_j + 1;
  const std::int32_t near_i = std::max(5, width / 20), near_j = std::max(5, height / 20);
  return enclosed.low_i - walls.low_i <= near_i && walls.high_i - enclosed.high_i <= near_i &&
         enclosed.low_j - walls.low_j <= near_j && walls.high_j - enclosed.high_j <= near_j &&
         4.0 * enclosed.cells >= static_cast<double>(width) * height;
}

}  // namespace

bool rasterise_walls(GridMap& map) {
  map.cells.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height), Cell::free);
  for (const GridWall& wall : map.walls) {
    for_each_touched_cell(
        map, wall, [&](std::int32_t i, std::int32_t j) { map.cells[map.index(i, j)] = Cell::occupied; });
  }
  flood_outside(map);
  const bool enclosed = fills(box_of(map, Cell::free), box_of(map, Cell::occupied));
  if (!enclosed) std::replace(map.cells.begin(), map.cells.end(), Cell::unknown, Cell::free);
  return enclosed;
}

double raster_error_m(const GridMap& map) {
  std::vector<float> nearest(map.size(), std::numeric_limits<float>::infinity());
  for (const GridWall& wall : map.walls) {
    const double dx = double{wall.bx} - wall.ax, dy = double{wall.by} - wall.ay, square = dx * dx + dy * dy;
    for_each_touched_cell(map, wall, [&](std::int32_t i, std::int32_t j) {
      const double x = (i + 0.5) * map.resolution_m - wall.ax, y = (j + 0.5) * map.resolution_m - wall.ay;
      const double along = square > 0.0 ? std::clamp((x * dx + y * dy) / square, 0.0, 1.0) : 0.0;
      float& best = nearest[map.index(i, j)];
      const double u = x - along * dx, v = y - along * dy;
      best = std::min(best, static_cast<float>(std::sqrt(u * u + v * v)));
    });
  }
  float worst = 0.0f;
  for (std::size_t c = 0; c < nearest.size(); ++c) {
    if (map.cells[c] == Cell::occupied) worst = std::max(worst, nearest[c]);
  }
  return worst;
}

}  // namespace parloc
