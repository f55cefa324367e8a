// Gathers the walls of a segment file, whatever its format, and refuses what cannot be a wall.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "common/map/segment_map.h"

namespace parloc {

/// What is wrong with a wall, without the place; the reader adds that.
struct BrokenWall {
  std::string why;
};

/// All functions throw BrokenWall.
class WallCollector {
 public:
  static double checked(double coordinate_m) {
    if (!(std::fabs(coordinate_m) <= kFarthestWall_m)) {  // also NaN
      throw BrokenWall{
          fmt::format("expected coordinates from {:g} to {:g} m, which no map projection exceeds, "
                      "found {:g}",
                      -kFarthestWall_m, kFarthestWall_m, coordinate_m)};
    }
    return coordinate_m;
  }

  void add_segment(const MapWall& line) {
    if (lines_.size() >= kMostSegments)
      throw BrokenWall{fmt::format("expected at most {} segments, found more", kMostSegments)};
    lines_.push_back(line);
  }

  /// The walls between neighbouring points.
  void add_polyline(const std::vector<MapPoint>& points) {
    if (points.size() < 2)
      throw BrokenWall{fmt::format("expected a line of at least 2 points, found {}", points.size())};
    for (std::size_t k = 1; k < points.size(); ++k) add_segment({points[k - 1], points[k]});
  }

  /// The same and back to the first point, which may be repeated at the end or not.
  void add_polygon(std::vector<MapPoint> points) {
    if (points.size() > 1 && points.front().x_m == points.back().x_m &&
        points.front().y_m == points.back().y_m)
      points.pop_back();
    if (points.size() < 3)
      throw BrokenWall{
          fmt::format("expected a polygon of at least 3 different points, found {}", points.size())};
    points.push_back(points.front());
    add_polyline(points);
  }

  std::vector<MapWall> take() {
    if (lines_.empty()) throw BrokenWall{"expected at least one segment, found none"};
    return std::move(lines_);
  }

 private:
  std::vector<MapWall> lines_;
};

}  // namespace parloc
