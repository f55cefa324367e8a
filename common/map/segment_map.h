// A map that is made of straight walls: what a segment file says, before it becomes a GridMap. docs/maps.md.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/map/grid_map.h"

namespace parloc {

/// More than a building has, and few enough to be held in memory several times over.
inline constexpr std::size_t kMostSegments = 1'000'000;
/// Several times what a million segments take.
inline constexpr std::size_t kLongestSegmentFile = std::size_t{256} * 1024 * 1024;
/// Farther from the origin than any map projection reaches [m].
inline constexpr double kFarthestWall_m = 1e8;

/// A point of the map frame [m].
struct MapPoint {
  double x_m;  ///< Along the map's x axis.
  double y_m;  ///< And along its y axis.
};

/// A straight wall from a to b in the map frame.
struct MapWall {
  MapPoint a;  ///< One end.
  MapPoint b;  ///< The other.
};

/// What a segment file holds, in the order of the file.
struct SegmentMap {
  std::string name;            ///< As the file names itself; may be empty.
  double resolution_m = 0.05;  ///< Of the grid that is made of it.
  std::vector<MapWall> lines;  ///< Each piece of a polyline or polygon by itself.
};

/// Whether a text is a segment file in GeoJSON. `path` counts only by its extension: .json and .geojson are.
/// Never throws.
bool is_geojson(const std::string& text, const std::string& path);
/// Whether a text is a segment file in YAML rather than the YAML file of a map_server map. Never throws.
bool is_segment_yaml(const std::string& text);
/// Whether a text is a segment file. Never throws: a text that is neither is not one.
inline bool is_segment_text(const std::string& text, const std::string& path) {
  return is_geojson(text, path) || is_segment_yaml(text);
}

/// `name` is used in messages only. All throw Error{input} naming file (and line in YAML, place in GeoJSON)
/// and what was expected: an unknown key (with the nearest valid one), a point that is not two numbers within
/// kFarthestWall_m, a line of fewer than 2 or a polygon of fewer than 3 points, more than kMostSegments
/// segments, or none at all.
SegmentMap segment_map_from_yaml(const std::string& text, const std::string& name);
/// The same from GeoJSON.
SegmentMap segment_map_from_geojson(const std::string& text, const std::string& name);
/// From whichever the text is; `path` as in is_geojson.
SegmentMap segment_map_from_text(const std::string& text, const std::string& path);

/// A segment map as what everything else works on, and what was left out of it.
struct PlacedSegments {
  GridMap map;                  ///< With its walls.
  std::size_t zero_length = 0;  ///< Both ends the same, in the precision of a GridWall.
  std::size_t duplicates = 0;   ///< The same ends as an earlier one, in either order.
  bool enclosed = false;        ///< The walls form a closed ring: outside of it is unknown, else free.
};

/// The walls in the frame of a grid that lies around them with a margin of a few cells, its corner on half a
/// multiple of the resolution, so that round coordinates fall on the middle of cells; and the grid
/// (common/map/rasterise.h). `name` becomes the map's name and is used in messages. Throws Error{input} if
/// the grid would be too large, or if no segment remains.
PlacedSegments place_segments(const SegmentMap& segments, const std::string& name);

/// Writes the walls of `map` in the map frame: GeoJSON if `path` ends in .geojson or .json, else YAML.
/// Walls that follow each other become one polyline or polygon. Every coordinate has as few digits as give
/// the same float again in the map's grid frame. `name` is what the file is to call itself; may be empty.
/// Throws Error{output}; also if the map has no walls.
void write_segment_map(const std::string& path, const GridMap& map, const std::string& name = {});
/// The YAML that write_segment_map writes.
std::string segment_yaml_of(const GridMap& map, const std::string& name = {});
/// The GeoJSON that write_segment_map writes.
std::string geojson_of(const GridMap& map, const std::string& name = {});

}  // namespace parloc
