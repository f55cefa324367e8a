// An occupancy grid with its place in the map frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace parloc {

/// A straight piece of wall, from a to b in the grid frame of its map [m]. Closed: a ray that meets an end
/// point is stopped.
struct GridWall {
  float ax;  ///< One end, along the grid's x axis.
  float ay;  ///< And along its y axis.
  float bx;  ///< The other end, along x.
  float by;  ///< And along y.
};

/// What is known of a cell.
enum class Cell : std::uint8_t {
  free = 0,      ///< Nothing is there.
  occupied = 1,  ///< A wall, or another thing that stays.
  unknown = 2,   ///< Nobody has looked.
};

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
  std::vector<std::string>
      notes;  ///< What its file says that is not used, or not as it stands; one line each.

  /// Number of cells.
  std::size_t size() const { return cells.size(); }
  /// Whether the grid has a cell of this place.
  bool contains(std::int32_t i, std::int32_t j) const { return i >= 0 && j >= 0 && i < width && j < height; }
  /// Place of a cell of the grid.
  std::size_t index(std::int32_t i, std::int32_t j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i);
  }
  /// The cell of this place; unknown outside the grid.
  Cell at(std::int32_t i, std::int32_t j) const {
    return contains(i, j) ? cells[index(i, j)] : Cell::unknown;
  }
  /// The cell that a point of the map frame lies in (floor, so cell -1 is not mirrored onto cell 0).
  Cell at_point(double x_m, double y_m) const;
};

/// Whether it is a map. Throws Error{input} naming the map and what was expected: sides of 1 to 32767 cells,
/// width * height cells, each free, occupied or unknown, a resolution of 0.0001 to 1000 m, an origin and
/// walls that are finite.
void validate(const GridMap& map);

/// Which cells end a ray, and which are the walls that a distance is measured to: 1 for an occupied cell, and
/// for an unknown one if unknown_blocks; else 0.
std::vector<std::uint8_t> blocking_cells(const GridMap& map, bool unknown_blocks);

/// A grid from rows of text, top row first: '#' occupied, '.' or ' ' free, '?' unknown. For tests and
/// examples. Throws Error{input} if rows differ in length.
GridMap grid_from_text(const std::vector<std::string>& rows, double resolution_m,
                       const Pose& T_map_grid = {});

}  // namespace parloc
