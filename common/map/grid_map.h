// An occupancy grid with its place in the map frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/map/grid_wall.h"
#include "common/math/pose.h"

namespace parloc {

enum class Cell : std::uint8_t { free = 0, occupied = 1, unknown = 2 };

/// Row-major grid: cell (i, j) is cells[j * width + i], i along +x and j along +y of the grid frame, whose
/// origin is the lower-left corner of cell (0, 0). Outside the grid is unknown.
struct GridMap {
  std::int32_t width = 0;     ///< Cells along x, 1 to 32767.
  std::int32_t height = 0;    ///< Cells along y, 1 to 32767.
  double resolution_m = 0.0;  ///< Cell size.
  Pose T_map_grid;  ///< Pose of the grid's lower-left corner in the map frame; yaw is kept, not resampled.
  std::vector<Cell> cells;  ///< width * height.
  /// If not empty, what rays end at, exactly; the cells are then a picture of it: occupied where a wall
  /// passes.
  std::vector<GridWall> walls;
  std::string name;  ///< Where it came from, for messages and reports.

  std::size_t size() const { return cells.size(); }
  bool contains(std::int32_t i, std::int32_t j) const { return i >= 0 && j >= 0 && i < width && j < height; }
  Cell at(std::int32_t i, std::int32_t j) const {
    return contains(i, j) ? cells[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(i)]
                          : Cell::unknown;
  }
  /// The cell that a point of the map frame lies in (floor, so cell -1 is not mirrored onto cell 0).
  Cell at_point(double x_m, double y_m) const;
};

/// A grid from rows of text, top row first: '#' occupied, '.' or ' ' free, '?' unknown. For tests and
/// examples. Throws Error{input} if rows differ in length.
GridMap grid_from_text(const std::vector<std::string>& rows, double resolution_m,
                       const Pose& T_map_grid = {});

}  // namespace parloc
