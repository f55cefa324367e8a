#include "common/map/grid_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "common/map/map_limits.h"

namespace parloc {
namespace {

Cell cell_of_character(char c, std::size_t row) {
  switch (c) {
    case '#':
      return Cell::occupied;
    case '.':
    case ' ':
      return Cell::free;
    case '?':
      return Cell::unknown;
    default:
      throw input_error("text map", row + 1,
                        std::string("expected '#', '.', ' ' or '?', found the character '") + c + "'");
  }
}

void check_size(const std::vector<std::string>& rows) {
  const std::size_t width = rows.empty() ? 0 : rows[0].size();
  const std::size_t height = rows.size();
  const std::size_t longest = static_cast<std::size_t>(kMaxMapSide);
  if (width < 1 || width > longest || height < 1 || height > longest) {
    throw input_error("text map", 0,
                      "expected 1 to " + std::to_string(kMaxMapSide) + " rows and columns, found " +
                          std::to_string(height) + " rows of " + std::to_string(width));
  }
  for (std::size_t row = 0; row < height; ++row) {
    if (rows[row].size() != width) {
      throw input_error("text map", row + 1,
                        "expected " + std::to_string(width) + " characters as in the first row, found " +
                            std::to_string(rows[row].size()));
    }
  }
}

}  // namespace

Cell GridMap::at_point(double x_m, double y_m) const {
  const Pose p = relative({x_m, y_m, 0.0}, T_map_grid);
  const double i = std::floor(p.x_m / resolution_m);
  const double j = std::floor(p.y_m / resolution_m);
  if (!(i >= 0.0 && j >= 0.0 && i < width && j < height)) return Cell::unknown;  // outside, or not a number
  return at(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
}

void validate(const GridMap& map) {
  const auto expect = [&](bool good, const std::string& what) {
    if (!good)
      throw Error(ErrorKind::input, (map.name.empty() ? "map" : map.name) + ": expected a map with " + what);
  };
  const auto is_side = [](std::int32_t cells) { return cells >= 1 && cells <= kMaxMapSide; };
  expect(is_side(map.width) && is_side(map.height),
         fmt::format("sides of 1 to {} cells, got {} x {}", kMaxMapSide, map.width, map.height));
  const auto size = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  expect(map.size() == size,
         fmt::format("{} x {} = {} cells, got {}", map.width, map.height, size, map.size()));
  const auto is_cell = [](Cell c) { return c == Cell::free || c == Cell::occupied || c == Cell::unknown; };
  expect(std::all_of(map.cells.begin(), map.cells.end(), is_cell),
         "cells that are free, occupied or unknown");
  expect(map.resolution_m >= kFinestResolution_m && map.resolution_m <= kCoarsestResolution_m,
         fmt::format("a resolution of {} to {} m, got {}", kFinestResolution_m, kCoarsestResolution_m,
                     map.resolution_m));
  expect(is_finite(map.T_map_grid),
         fmt::format("an origin that is finite, got ({}, {}, {})", map.T_map_grid.x_m, map.T_map_grid.y_m,
                     map.T_map_grid.theta_rad));
  const auto is_wall = [](const GridWall& w) {
    return std::isfinite(w.ax) && std::isfinite(w.ay) && std::isfinite(w.bx) && std::isfinite(w.by);
  };
  expect(std::all_of(map.walls.begin(), map.walls.end(), is_wall), "walls that are finite");
}

std::vector<std::uint8_t> blocking_cells(const GridMap& map, bool unknown_blocks) {
  std::vector<std::uint8_t> blocks(map.size());
  for (std::size_t c = 0; c < blocks.size(); ++c)
    blocks[c] = map.cells[c] == Cell::occupied || (unknown_blocks && map.cells[c] == Cell::unknown) ? 1 : 0;
  return blocks;
}

GridMap grid_from_text(const std::vector<std::string>& rows, double resolution_m, const Pose& T_map_grid) {
  check_size(rows);
  if (!(std::isfinite(resolution_m) && resolution_m > 0.0)) {
    throw input_error("text map", 0, "expected a resolution above 0 m, got " + std::to_string(resolution_m));
  }
  GridMap map;
  map.width = static_cast<std::int32_t>(rows[0].size());
  map.height = static_cast<std::int32_t>(rows.size());
  map.resolution_m = resolution_m;
  map.T_map_grid = T_map_grid;
  map.name = "text map";
  map.cells.reserve(rows.size() * rows[0].size());
  for (std::size_t row = rows.size(); row-- > 0;) {  // the last row of text is j = 0
    for (const char c : rows[row]) map.cells.push_back(cell_of_character(c, row));
  }
  return map;
}

}  // namespace parloc
