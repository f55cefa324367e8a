#include "common/simulator/changed_world.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/philox.h"

namespace parloc {
namespace {

constexpr double kFurniture_m = 3.0;  // across; what is larger is a wall
constexpr double kLeastPiece_m = 0.3, kMostPiece_m = 1.5;
constexpr std::uint32_t kRemove = 0, kAdd = 1;  // third word of the counter: who draws

std::size_t index_of(const GridMap& map, std::int32_t i, std::int32_t j) {
  return static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(i);
}
std::int32_t column_of(const GridMap& map, std::size_t cell) {
  return static_cast<std::int32_t>(cell % static_cast<std::size_t>(map.width));
}
std::int32_t row_of(const GridMap& map, std::size_t cell) {
  return static_cast<std::int32_t>(cell / static_cast<std::size_t>(map.width));
}

Philox4x32 draw(std::uint32_t piece, std::uint32_t purpose, std::uint64_t seed) {
  return philox(piece, 0u, Stream::changed_world, purpose, seed);
}

double between(std::uint32_t word, double low, double high) {
  return low + static_cast<double>(uniform_unit(word)) * (high - low);
}

/// Calls visit(cell) for the occupied cells that are connected with `start`, over sides and corners, as long
/// as it returns true: only from those it goes on.
template <class Visit>
void flood_occupied(const GridMap& map, std::size_t start, Visit&& visit) {
  std::vector<std::size_t> open{start};
  while (!open.empty()) {
    const std::size_t cell = open.back();
    open.pop_back();
    if (!visit(cell)) continue;
    const std::int32_t i = column_of(map, cell), j = row_of(map, cell);
    for (std::int32_t dj = -1; dj <= 1; ++dj)
      for (std::int32_t di = -1; di <= 1; ++di)
        if ((di != 0 || dj != 0) && map.at(i + di, j + dj) == Cell::occupied)
          open.push_back(index_of(map, i + di, j + dj));
  }
}

/// The occupied cells: of furniture, and of walls.
struct OccupiedCells {
  std::vector<std::size_t> furniture, walls;
  std::size_t count() const { return furniture.size() + walls.size(); }
};

OccupiedCells sort_occupied(const GridMap& map) {
  OccupiedCells sorted;
  std::vector<std::uint8_t> seen(map.size());
  std::vector<std::size_t> body;
  for (std::size_t start = 0; start < map.size(); ++start) {
    if (map.cells[start] != Cell::occupied || seen[start] != 0) continue;
    body.clear();
    std::int32_t low_i = map.width, high_i = 0, low_j = map.height, high_j = 0;
    flood_occupied(map, start, [&](std::size_t cell) {
      if (std::exchange(seen[cell], std::uint8_t{1}) != 0) return false;
      body.push_back(cell);
      low_i = std::min(low_i, column_of(map, cell)), high_i = std::max(high_i, column_of(map, cell));
      low_j = std::min(low_j, row_of(map, cell)), high_j = std::max(high_j, row_of(map, cell));
      return true;
    });
    const double across_m = map.resolution_m * (1 + std::max(high_i - low_i, high_j - low_j));
    std::vector<std::size_t>& into = across_m < kFurniture_m ? sorted.furniture : sorted.walls;
    into.insert(into.end(), body.begin(), body.end());
  }
  return sorted;
}

/// Takes away pieces around cells of `from` until `wanted` cells are gone, or nearly all of `from`.
void remove_pieces(const GridMap& map, const std::vector<std::size_t>& from, std::size_t wanted,
                   std::uint64_t seed, std::uint32_t& piece, std::vector<std::uint8_t>& gone,
                   std::vector<std::size_t>& removed) {
  constexpr std::uint32_t kMostMisses = 50;  // in a row, of cells that are gone
  for (std::uint32_t misses = 0; !from.empty() && removed.size() < wanted && misses < kMostMisses; ++piece) {
    const Philox4x32 r = draw(piece, kRemove, seed);
    const std::size_t centre = from[uniform_below(r.w[0], static_cast<std::uint32_t>(from.size()))];
    if (gone[centre] != 0) {
      ++misses;
      continue;
    }
    misses = 0;
    const double reach = 0.5 * between(r.w[1], kLeastPiece_m, kMostPiece_m) / map.resolution_m;
    const std::int32_t i = column_of(map, centre), j = row_of(map, centre);
    flood_occupied(map, centre, [&](std::size_t cell) {
      const double di = column_of(map, cell) - i, dj = row_of(map, cell) - j;
      if (gone[cell] != 0 || di * di + dj * dj > reach * reach) return false;
      gone[cell] = 1;
      removed.push_back(cell);
      return true;
    });
  }
}

/// Puts down filled boxes where the map is free until `wanted` cells are occupied, or no place was found.
void add_pieces(const GridMap& map, const std::vector<std::uint8_t>& kept_free, std::size_t wanted,
                std::uint64_t seed, std::vector<std::size_t>& added) {
  constexpr std::uint32_t kMostMisses = 2000;  // in a row
  std::vector<std::uint8_t> taken(map.size());
  std::uint32_t piece = 0;
  for (std::uint32_t misses = 0; added.size() < wanted && misses < kMostMisses; ++piece, ++misses) {
    const Philox4x32 r = draw(piece, kAdd, seed);
    const std::size_t corner = uniform_below(r.w[0], static_cast<std::uint32_t>(map.size()));
    if (map.cells[corner] != Cell::free) continue;
    const auto side = [&](std::uint32_t word) {
      return std::max(1, static_cast<std::int32_t>(
                             std::lround(between(word, kLeastPiece_m, kMostPiece_m) / map.resolution_m)));
    };
    const std::int32_t i = column_of(map, corner), j = row_of(map, corner);
    const std::int32_t width = side(r.w[1]), height = side(r.w[2]);
    std::vector<std::size_t> box;
    bool room = i + width <= map.width && j + height <= map.height;
    for (std::int32_t v = j; room && v < j + height; ++v)
      for (std::int32_t u = i; room && u < i + width; ++u) {
        const std::size_t cell = index_of(map, u, v);
        room = map.cells[cell] == Cell::free && kept_free[cell] == 0 && taken[cell] == 0;
        box.push_back(cell);
      }
    if (!room) continue;
    for (const std::size_t cell : box) taken[cell] = 1;
    added.insert(added.end(), box.begin(), box.end());
    misses = 0;
  }
}

}  // namespace

std::vector<std::uint8_t> cells_near_path(const GridMap& map, const WaypointPath& path, double clearance_m) {
  std::vector<std::uint8_t> near(map.size());
  const auto reach = static_cast<std::int32_t>(std::ceil(clearance_m / map.resolution_m));
  const auto mark = [&](double x_m, double y_m) {
    const Pose p = relative({x_m, y_m, 0.0}, map.T_map_grid);
    const auto i = static_cast<std::int32_t>(std::floor(p.x_m / map.resolution_m));
    const auto j = static_cast<std::int32_t>(std::floor(p.y_m / map.resolution_m));
    for (std::int32_t v = j - reach; v <= j + reach; ++v)
      for (std::int32_t u = i - reach; u <= i + reach; ++u)
        if (map.contains(u, v)) near[index_of(map, u, v)] = 1;
  };
  for (std::size_t k = 1; k < path.points.size(); ++k) {
    const Waypoint &a = path.points[k - 1], &b = path.points[k];
    const double dx_m = b.x_m - a.x_m, dy_m = b.y_m - a.y_m;
    const double steps = std::ceil(std::sqrt(dx_m * dx_m + dy_m * dy_m) / map.resolution_m);
    for (double s = 0.0; s <= steps; s += 1.0) mark(a.x_m + s / steps * dx_m, a.y_m + s / steps * dy_m);
  }
  return near;
}

WorldChange move_furniture(const GridMap& map, const WaypointPath& path, double clearance_m, double share,
                           std::uint64_t seed) {
  WorldChange change;
  const OccupiedCells occupied = sort_occupied(map);
  const auto wanted =
      static_cast<std::size_t>(std::lround(0.5 * share * static_cast<double>(occupied.count())));
  std::vector<std::uint8_t> gone(map.size());
  std::uint32_t piece = 0;
  for (const std::vector<std::size_t>* from : {&occupied.furniture, &occupied.walls})
    remove_pieces(map, *from, wanted, seed, piece, gone, change.removed);
  add_pieces(map, cells_near_path(map, path, clearance_m), wanted, seed, change.added);
  std::sort(change.removed.begin(), change.removed.end());
  std::sort(change.added.begin(), change.added.end());
  return change;
}

GridMap changed_world(const GridMap& world, const GridMap& map, const WorldChange& change) {
  GridMap changed = world;
  std::vector<std::uint8_t> gone(change.removed.empty() ? 0 : map.size());
  for (const std::size_t cell : change.removed) gone[cell] = 1;
  const auto map_cell = [&](std::int32_t u, std::int32_t v) {  // that the centre of a cell of the world is in
    const Pose p = relative(
        compose(world.T_map_grid, {(u + 0.5) * world.resolution_m, (v + 0.5) * world.resolution_m, 0.0}),
        map.T_map_grid);
    return std::pair(static_cast<std::int32_t>(std::floor(p.x_m / map.resolution_m)),
                     static_cast<std::int32_t>(std::floor(p.y_m / map.resolution_m)));
  };
  const auto for_each_within = [&](std::size_t cell, std::int32_t margin, auto visit) {
    const std::int32_t i = column_of(map, cell) - margin, j = row_of(map, cell) - margin;
    const double size_m = (1 + 2 * margin) * map.resolution_m;
    const Pose low = relative(compose(map.T_map_grid, {i * map.resolution_m, j * map.resolution_m, 0.0}),
                              world.T_map_grid);
    const auto from_u = static_cast<std::int32_t>(std::floor(low.x_m / world.resolution_m));
    const auto from_v = static_cast<std::int32_t>(std::floor(low.y_m / world.resolution_m));
    const auto cells = static_cast<std::int32_t>(std::ceil(size_m / world.resolution_m)) + 1;
    for (std::int32_t v = from_v; v < from_v + cells; ++v)
      for (std::int32_t u = from_u; u < from_u + cells; ++u)
        if (world.contains(u, v)) visit(changed.cells[index_of(world, u, v)], u, v);
  };
  // A wall of the world reaches into cells that the map has as free: what belongs to none that stays goes
  // too.
  for (const std::size_t cell : change.removed)
    for_each_within(cell, 1, [&](Cell& value, std::int32_t u, std::int32_t v) {
      if (value != Cell::occupied) return;
      const auto [i, j] = map_cell(u, v);
      const bool stays = map.at(i, j) == Cell::occupied && gone[index_of(map, i, j)] == 0;
      if (!stays) value = Cell::free;
    });
  for (const std::size_t cell : change.added)
    for_each_within(cell, 0, [&](Cell& value, std::int32_t u, std::int32_t v) {
      if (map_cell(u, v) == std::pair(column_of(map, cell), row_of(map, cell))) value = Cell::occupied;
    });
  return changed;
}

Pose scaled_about_grid(const Pose& pose, const Pose& T_map_grid, double scale) {
  const Pose p = relative(pose, T_map_grid);
  return compose(T_map_grid, {scale * p.x_m, scale * p.y_m, p.theta_rad});
}

}  // namespace parloc
