// What every reader of segment maps must hold: any text is a map whose walls can be placed, written and read
// again, or an Error{input} of one line.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/map/segment_map.h"
#include "tests/fuzz/one_line.h"

namespace parloc::fuzz {

using SegmentReader = SegmentMap (*)(const std::string& text, const std::string& name);

/// Cells are made for what is small: the time of an input should go to its text.
inline bool small(const SegmentMap& segments) {
  constexpr double kMostCells = 500.0;
  double low = 1e9, high = -1e9;
  for (const MapWall& line : segments.lines) {
    for (const double v : {line.a.x_m, line.a.y_m, line.b.x_m, line.b.y_m})
      low = std::min(low, v), high = std::max(high, v);
  }
  return (high - low) / segments.resolution_m < kMostCells;
}

inline void check_placed(const SegmentMap& segments) {
  const PlacedSegments placed = place_segments(segments, "fuzz");
  const GridMap& map = placed.map;
  require(map.walls.size() + placed.zero_length + placed.duplicates == segments.lines.size());
  require(map.size() == static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  for (const GridWall& wall : map.walls) {
    const auto i = static_cast<int>(wall.ax / map.resolution_m),
               j = static_cast<int>(wall.ay / map.resolution_m);
    require(map.contains(i, j) && map.at(i, j) == Cell::occupied);
  }
  const SegmentMap yaml = segment_map_from_yaml(segment_yaml_of(map, segments.name), "written");
  const SegmentMap json = segment_map_from_geojson(geojson_of(map, segments.name), "written");
  require(yaml.lines.size() == map.walls.size() && json.lines.size() == map.walls.size());
}

inline void check_segments(SegmentReader read, const std::string& text) {
  reads_or_says_why(ErrorKind::input, [&] {
    is_segment_text(text, "fuzz");
    const SegmentMap segments = read(text, "fuzz");
    require(!segments.lines.empty() && segments.lines.size() <= text.size());
    require(segments.resolution_m > 0.0 && std::isfinite(segments.resolution_m));
    for (const MapWall& line : segments.lines) {
      for (const double v : {line.a.x_m, line.a.y_m, line.b.x_m, line.b.y_m})
        require(std::fabs(v) <= kFarthestWall_m);
    }
    if (small(segments)) check_placed(segments);
  });
}

}  // namespace parloc::fuzz
