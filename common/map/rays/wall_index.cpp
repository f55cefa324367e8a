#include "common/map/rays/wall_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"

namespace parloc {
namespace {

/// Farther than a hit may be from the cells that its ray visits: see wall_hit.
double margin_cells(const GridMap& map) {
  return 0.02 + 4e-6 * std::max(map.width, map.height);
}

RayWall wall_in_cells(const GridWall& s, double inv_resolution) {
  const auto cells = [&](float metres) {
    return static_cast<float>(static_cast<double>(metres) * inv_resolution);
  };
  const float ax = cells(s.ax), ay = cells(s.ay);
  return {ax, ay, cells(s.bx) - ax, cells(s.by) - ay};
}

/// visit(main, other) for every cell within `margin` of the wall; main: along x unless the wall is steep.
template <class Visit>
void along_wall(const RayWall& w, double margin, const Visit& visit) {
  const bool steep = std::fabs(w.ey) > std::fabs(w.ex);
  const double a = steep ? w.ay : w.ax, e = steep ? w.ey : w.ex;
  const double other_a = steep ? w.ax : w.ay, other_e = steep ? w.ex : w.ey;
  const double slope = e == 0.0 ? 0.0 : other_e / e;
  const double low = std::min(a, a + e), high = std::max(a, a + e);
  const auto cell = [](double x) { return static_cast<std::int32_t>(std::floor(x)); };
  for (std::int32_t m = cell(low - margin); m <= cell(high + margin); ++m) {
    const double from = std::clamp(m - margin, low, high), to = std::clamp(m + 1 + margin, low, high);
    const double at_from = other_a + slope * (from - a), at_to = other_a + slope * (to - a);
    const std::int32_t last = cell(std::max(at_from, at_to) + margin);
    for (std::int32_t o = cell(std::min(at_from, at_to) - margin); o <= last; ++o)
      visit(steep ? o : m, steep ? m : o);
  }
}

}  // namespace

WallIndex index_walls(const GridMap& map) {
  WallIndex index;
  for (const GridWall& s : map.walls) {
    index.walls.push_back(wall_in_cells(s, 1.0 / map.resolution_m));
    const RayWall& w = index.walls.back();
    const float far_x = std::max(w.ax, w.ax + w.ex), far_y = std::max(w.ay, w.ay + w.ey);
    if (std::min(w.ax, w.ax + w.ex) < 1.0f || std::min(w.ay, w.ay + w.ey) < 1.0f ||
        far_x > static_cast<float>(map.width - 1) || far_y > static_cast<float>(map.height - 1))
      throw Error(ErrorKind::internal, map.name + ": expected all walls a cell or more inside the grid");
  }
  const double margin = margin_cells(map);
  std::vector<std::uint64_t> count(map.size(), 0);
  std::uint64_t total = 0;
  for (const RayWall& w : index.walls) {
    along_wall(w, margin, [&](std::int32_t i, std::int32_t j) {
      if (map.contains(i, j)) ++count[map.index(i, j)], ++total;
    });
  }
  if (total > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorKind::internal, map.name + ": expected fewer walls, or a coarser resolution");

  index.first.resize(map.size() + 1);
  index.blocks.resize(map.size());
  for (std::size_t c = 0; c < map.size(); ++c) {
    index.first[c + 1] = index.first[c] + static_cast<std::uint32_t>(count[c]);
    index.blocks[c] = count[c] > 0 ? 1 : 0;
  }
  index.ids.resize(total);
  std::vector<std::uint32_t> next(index.first.begin(), index.first.end() - 1);
  for (std::size_t k = 0; k < index.walls.size(); ++k) {
    along_wall(index.walls[k], margin, [&](std::int32_t i, std::int32_t j) {
      if (map.contains(i, j)) index.ids[next[map.index(i, j)]++] = static_cast<std::uint32_t>(k);
    });
  }
  return index;
}

}  // namespace parloc
