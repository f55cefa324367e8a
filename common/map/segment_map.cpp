#include "common/map/segment_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "common/error.h"
#include "common/map/map_limits.h"
#include "common/map/rasterise.h"

namespace parloc {
namespace {

constexpr double kMargin = 3.0;  // cells around the walls
/// 268 million cells of a byte each. A far point in a small file must not cost the memory of a large map.
constexpr double kMostCells = 0x1p28;

struct Box {
  double low_x = std::numeric_limits<double>::infinity(), low_y = low_x;
  double high_x = -low_x, high_y = -low_x;
};

Box box_of(const std::vector<MapWall>& lines) {
  Box box;
  for (const MapWall& line : lines) {
    for (const MapPoint& p : {line.a, line.b}) {
      box.low_x = std::min(box.low_x, p.x_m), box.high_x = std::max(box.high_x, p.x_m);
      box.low_y = std::min(box.low_y, p.y_m), box.high_y = std::max(box.high_y, p.y_m);
    }
  }
  return box;
}

/// Where the grid begins when the first wall is at `low_m`. The thousandth of a cell keeps rounding from
/// moving a wall on a round coordinate, and with it the whole grid, by a cell.
double grid_start(double low_m, double resolution_m) {
  return (std::floor(low_m / resolution_m + 1e-3) - kMargin - 0.5) * resolution_m;
}

double cells_to(double high_m, double start_m, double resolution_m) {
  return std::floor((high_m - start_m) / resolution_m) + 1.0 + kMargin;
}

/// The grid around the walls, without cells.
GridMap empty_grid(const SegmentMap& segments, const std::string& name) {
  const Box box = box_of(segments.lines);
  GridMap map;
  map.resolution_m = segments.resolution_m;
  map.name = name;
  map.T_map_grid = {grid_start(box.low_x, map.resolution_m), grid_start(box.low_y, map.resolution_m), 0.0};
  const double width = cells_to(box.high_x, map.T_map_grid.x_m, map.resolution_m);
  const double height = cells_to(box.high_y, map.T_map_grid.y_m, map.resolution_m);
  if (!(width <= kMaxMapSide && height <= kMaxMapSide && width * height <= kMostCells)) {
    throw input_error(
        name, 0,
        fmt::format(
            "the walls span {:.6g} x {:.6g} m, {:.0f} x {:.0f} cells of {:g} m: expected at most {} on "
            "a side and {:.0f} in all; give a coarser 'resolution'",
            box.high_x - box.low_x, box.high_y - box.low_y, width, height, map.resolution_m, kMaxMapSide,
            kMostCells));
  }
  map.width = static_cast<std::int32_t>(width);
  map.height = static_cast<std::int32_t>(height);
  return map;
}

GridWall in_grid(const MapWall& line, const Pose& origin) {
  return {static_cast<float>(line.a.x_m - origin.x_m), static_cast<float>(line.a.y_m - origin.y_m),
          static_cast<float>(line.b.x_m - origin.x_m), static_cast<float>(line.b.y_m - origin.y_m)};
}

/// The ends of a segment, the smaller one first: the same for both directions.
using Ends = std::array<float, 4>;
Ends ends_of(const GridWall& s) {
  return std::pair(s.ax, s.ay) < std::pair(s.bx, s.by) ? Ends{s.ax, s.ay, s.bx, s.by}
                                                       : Ends{s.bx, s.by, s.ax, s.ay};
}
struct EndsHash {
  std::size_t operator()(const Ends& ends) const {
    std::size_t hash = 0;
    for (const float value : ends) hash = (hash ^ std::hash<float>{}(value)) * 0x9E3779B97F4A7C15u;
    return hash ^ hash >> 32;
  }
};

}  // namespace

bool is_geojson(const std::string& text, const std::string& path) {
  const auto ends_with = [&](std::string_view end) {
    return path.size() >= end.size() && path.compare(path.size() - end.size(), end.size(), end) == 0;
  };
  if (ends_with(".geojson") || ends_with(".json")) return true;
  const std::size_t start = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return start != std::string::npos && text[start] == '{' && text.find("\"type\"") != std::string::npos;
}

SegmentMap segment_map_from_text(const std::string& text, const std::string& path) {
  return is_geojson(text, path) ? segment_map_from_geojson(text, path) : segment_map_from_yaml(text, path);
}

PlacedSegments place_segments(const SegmentMap& segments, const std::string& name) {
  if (segments.lines.empty()) throw input_error(name, 0, "expected at least one segment, found none");
  PlacedSegments placed;
  placed.map = empty_grid(segments, name);
  std::vector<GridWall>& walls = placed.map.walls;
  walls.reserve(segments.lines.size());
  std::unordered_set<Ends, EndsHash> seen(segments.lines.size());
  for (const MapWall& line : segments.lines) {
    const GridWall wall = in_grid(line, placed.map.T_map_grid);
    if (wall.ax == wall.bx && wall.ay == wall.by) {
      ++placed.zero_length;
    } else if (!seen.insert(ends_of(wall)).second) {
      ++placed.duplicates;
    } else {
      walls.push_back(wall);
    }
  }
  if (walls.empty()) {
    throw input_error(
        name, 0,
        fmt::format("expected a segment that is longer than zero, found none in {}", segments.lines.size()));
  }
  placed.enclosed = rasterise_walls(placed.map);
  return placed;
}

}  // namespace parloc
