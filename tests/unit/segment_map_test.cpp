// GridWall maps: the YAML and GeoJSON readers, and the grid that is made of the walls.
#include "common/map/segment_map.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "common/map/map_reader.h"
#include "common/map/rasterise.h"
#include "tests/unit/expect.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

using test::TempFile;

using Read = SegmentMap (*)(const std::string& text, const std::string& name);

/// The one line of the input error that reading gives has this part.
void expect_error(Read read, const std::string& text, const std::string& part) {
  const std::string message = error_of([&] { read(text, "walls"); });
  expect_none_of(message, {"\n"});
  expect_parts(message, {part});
}

/// "ax ay bx by" per line.
std::string text_of(const std::vector<MapWall>& lines) {
  std::string text;
  for (const MapWall& l : lines) {
    char row[120];
    std::snprintf(row, sizeof row, "%g %g %g %g\n", l.a.x_m, l.a.y_m, l.b.x_m, l.b.y_m);
    text += row;
  }
  return text;
}

// ---- YAML -----------------------------------------------------------------------------------------

TEST(SegmentYaml, ReadsEveryKindOfWall) {
  const SegmentMap map = segment_map_from_yaml(
      "# a room\nname: room 7\nresolution: 0.1\n"
      "segments:\n  - [0, 0, 10, 0]\n  - [+1.5, -2e0, 3, .5]\n"
      "polylines: [[[0, 0], [1, 0], [1, 1]]]\n"
      "polygons:\n  - [[0, 0], [4, 0], [4, 3]]\n  - - [7, 7]\n    - [8, 7]\n    - [8, 8]\n    - [7, 7]\n",
      "walls");
  EXPECT_EQ(map.name, "room 7");
  EXPECT_EQ(map.resolution_m, 0.1);
  EXPECT_EQ(text_of(map.lines),
            "0 0 10 0\n1.5 -2 3 0.5\n"
            "0 0 1 0\n1 0 1 1\n"
            "0 0 4 0\n4 0 4 3\n4 3 0 0\n"
            "7 7 8 7\n8 7 8 8\n8 8 7 7\n");
}

TEST(SegmentYaml, DefaultsAndEmptyLists) {
  const SegmentMap map = segment_map_from_yaml("{segments: [[0, 0, 1, 0]], polygons: []}", "walls");
  EXPECT_EQ(map.name, "");
  EXPECT_EQ(map.resolution_m, 0.05);
  EXPECT_EQ(map.lines.size(), 1u);
}

TEST(SegmentYaml, EveryErrorSaysWhereAndWhat) {
  const struct {
    const char* text;
    const char* part;
  } cases[] = {
      {"segments: [[0, 0, 1, 0]]\nsegmnts: []\n",
       "walls:2: unknown key 'segmnts'; the nearest valid key is 'segments'"},
      {"polygon: []\n", "nearest valid key is 'polygons'"},
      {"segments: []\nsegments: []\n", "walls:2: duplicate key 'segments', first on line 1"},
      {"segments:\n- [0, 0, 1, 0]\n- [0, 0, 1]\n",
       "walls:3: segments[1]: expected 4 numbers [ax, ay, bx, by], found 3"},
      {"segments: [[0, 0, 1, 0, 2]]", "found 5"},
      {"segments: [[]]", "found 0"},
      {"segments: [0, 0, 1, 0]",
       "walls:1: segments: expected a list of [ax, ay, bx, by] in metres, found '0'"},
      {"segments: [[[0, 0, 1, 0]]]", "found a list"},
      {"segments: 3", "found '3'"},
      {"segments:", "found nothing"},
      {"segments: {a: 1}", "found a group"},
      {"segments: [[0, 0, 1, left]]", "segments[0]: expected a number, found 'left'"},
      {"segments: [[0, 0, 1, nan]]", "segments[0]: expected coordinates from -1e+08 to 1e+08 m"},
      {"segments: [[0, 0, 1, -inf]]", "expected coordinates from"},
      {"segments: [[0, 0, 1, 2e8]]", "found 2e+08"},
      {"segments: [[0, 0, 1, 1e999]]", "expected a number"},
      {"segments: [[0, 0, 1, ]]", "found 3"},
      {"polygons: [[[0, 0], [1, 0]]]",
       "polygons[0]: expected a polygon of at least 3 different points, found 2"},
      {"polygons: [[[0, 0], [1, 0], [0, 0]]]", "at least 3 different points, found 2"},
      {"polygons: [[[0, 0], [1, 0], [0, 1, 5]]]", "expected 2 numbers [x, y], found 3"},
      {"polylines: [[[0, 0]]]", "polylines[0]: expected a line of at least 2 points, found 1"},
      {"polylines: [[]]", "at least 2 points, found 0"},
      {"polylines: [[0, 0], [1, 1]]", "expected a list of lists of points [x, y] in metres, found '0'"},
      {"resolution: 0\nsegments: [[0, 0, 1, 0]]", "walls:1: resolution must be 0.0001 to 1000, got 0"},
      {"resolution: [1]\n", "resolution: expected a single value, found a list"},
      {"name: [a]\n", "name: expected a single value, found a list"},
      {"name: x\n", "walls: expected at least one segment, found none"},
      {"segments: []\n", "walls: expected at least one segment, found none"},
      {"", "expected at least one segment"},
      {"- [0, 0, 1, 0]\n", "expected lines of 'key: value', found a list"},
      {"segments: [[0, 0, 1, 0]]\n---\nname: b\n", "walls:2: expected one document, found a second one"},
      {"segments: &a [[0, 0, 1, 0]]\npolylines: *a\n", "aliases"},
      {"segments: [[0, 0, 1, 0]", "walls:1: segments: expected a list"},  // the end is missing
      {"segments: \"[[0", "walls:1: not valid YAML"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.text);
    expect_error(segment_map_from_yaml, c.text, c.part);
  }
}

TEST(SegmentYaml, AMillionSegmentsAreRead) {
  // One more than the limit as a polyline, which is quicker to read than as many segments.
  std::string text = "polylines:\n- [";
  for (std::size_t k = 0; k <= kMostSegments; ++k) text += k % 2 == 0 ? "[0,0]," : "[1,0],";
  EXPECT_EQ(segment_map_from_yaml(text + "]\n", "walls").lines.size(), kMostSegments);
  expect_error(segment_map_from_yaml, text + "[2,2]]\n",
               "polylines[0]: expected at most 1000000 segments, found more");
}

// ---- GeoJSON ----------------------------------------------------------------------------------------

TEST(Geojson, ReadsEveryGeometryOfLines) {
  const SegmentMap map = segment_map_from_geojson(
      R"({"type": "FeatureCollection", "name": "floor 2", "resolution": 0.2, "crs": {"type": "name"}, "features": [
        {"type": "Feature", "properties": null, "geometry":
          {"type": "LineString", "coordinates": [[0, 0, 9], [1, 0, 9], [1, 2]]}},
        {"type": "Feature", "geometry": null},
        {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [
          [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]], [[3, 3], [4, 3], [4, 4], [3, 3]]]}},
        {"type": "Feature", "geometry": {"type": "GeometryCollection", "geometries": [
          {"type": "MultiLineString", "coordinates": [[[0, 0], [5, 5]], [[1, 1], [2, 1]]]},
          {"type": "MultiPolygon", "coordinates": [[[[0, 0], [1, 0], [1, 1], [0, 0]]]]}]}}]})",
      "walls");
  EXPECT_EQ(map.name, "floor 2");
  EXPECT_EQ(map.resolution_m, 0.2);
  EXPECT_EQ(text_of(map.lines),
            "0 0 1 0\n1 0 1 2\n"
            "0 0 9 0\n9 0 9 9\n9 9 0 9\n0 9 0 0\n3 3 4 3\n4 3 4 4\n4 4 3 3\n"
            "0 0 5 5\n1 1 2 1\n"
            "0 0 1 0\n1 0 1 1\n1 1 0 0\n");
}

TEST(Geojson, ABareGeometryOrFeatureWillDo) {
  const std::string line = R"({"type": "LineString", "coordinates": [[0, 0], [1, 0]]})";
  EXPECT_EQ(segment_map_from_geojson(line, "walls").lines.size(), 1u);
  EXPECT_EQ(segment_map_from_geojson("\xEF\xBB\xBF" + line, "walls").lines.size(), 1u);
  EXPECT_EQ(
      segment_map_from_geojson(R"({"type": "Feature", "geometry": )" + line + "}", "walls").lines.size(), 1u);
}

TEST(Geojson, EveryErrorSaysWhereAndWhat) {
  const auto feature = [](const std::string& geometry) {
    return R"({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": null}, )"
           R"({"type": "Feature", "geometry": )" +
           geometry + "}]}";
  };
  const auto line = [](const std::string& coordinates) {
    return R"({"type": "LineString", "coordinates": )" + coordinates + "}";
  };
  const struct {
    std::string text;
    const char* part;
  } cases[] = {
      {feature(R"({"type": "Point", "coordinates": [0, 0]})"),
       "walls: features[1].geometry: expected LineString, MultiLineString, Polygon, MultiPolygon or "
       "GeometryCollection, found 'Point'"},
      {feature(R"({"type": "Linestring", "coordinates": []})"), "the nearest type is 'LineString'"},
      {feature(line("[[0, 0]]")),
       "features[1].geometry.coordinates: expected a line of at least 2 points, found 1"},
      {feature(line("[[0, 0], [1]]")),
       "features[1].geometry.coordinates[1]: expected a point [x, y] in metres"},
      {line("[[0, 0], [1, \"2\"]]"), "coordinates[1]: expected a point"},
      {line("[[0, 0], [1, null]]"), "expected a point"},
      {line("[[0, 0], [1, 1e9]]"), "coordinates[1]: expected coordinates from -1e+08 to 1e+08 m"},
      {line("[[0, 0], [1, 1e999]]"), "not valid JSON: a number is too large"},
      {line("[0, 1]"), "expected a point"},
      {line("7"), "expected a list 'coordinates'"},
      {R"({"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [0, 0]]]})",
       "coordinates[0]: expected a polygon of at least 3 different points, found 2"},
      {R"({"type": "MultiPolygon", "coordinates": [[[[0, 0], [1, 0], [1, 1]]], [[[0, 0]]]]})",
       "coordinates[1][0]: expected a polygon of at least 3 different points, found 1"},
      {R"({"type": "MultiPolygon", "coordinates": [[1]]})", "coordinates[0][0]: expected a list"},
      {R"({"type": "GeometryCollection", "geometries": [{"type": "Point"}]})",
       "geometries[0]: expected LineString"},
      {R"({"type": "GeometryCollection"})", "expected a list 'geometries'"},
      {R"({"type": "FeatureCollection", "features": [{"type": "Polygon"}]})",
       "features[0]: expected a Feature, found 'Polygon'"},
      {R"({"type": "FeatureCollection", "features": [{"type": "Feature"}]})",
       "features[0]: expected a 'geometry'"},
      {R"({"type": "FeatureCollection", "features": [3]})", "features[0]: expected an object with a 'type'"},
      {R"({"type": "FeatureCollection", "features": []})", "expected at least one segment, found none"},
      {R"({"type": 7})", "expected a 'type' that is a text"},
      {R"({"resolution": -1, "type": "LineString"})", "resolution: must be 0.0001 to 1000 m"},
      {"[]", "expected a GeoJSON object"},
      {"{\n\"type\": \n oops}", "walls:3: not valid JSON"},
      {"", "walls:1: not valid JSON"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.text);
    expect_error(segment_map_from_geojson, c.text, c.part);
  }
}

TEST(Geojson, DeepNestingIsAnErrorAndNoCrash) {
  std::string deep, close;
  for (int k = 0; k < 100'000; ++k) {
    deep += R"({"type":"GeometryCollection","geometries":[)";
    close += "]}";
  }
  const std::string open(200'000, '['), shut(200'000, ']');
  expect_error(segment_map_from_geojson, deep + close, "at most 16 collections");
  expect_error(segment_map_from_geojson, R"({"type": "LineString", "coordinates": )" + open + shut + "}",
               "expected a point");
  expect_error(segment_map_from_geojson, open, "not valid JSON");
}

// ---- which kind of file ---------------------------------------------------------------------------------

TEST(SegmentMapKind, IsToldByContentAndEnding) {
  for (const char* walls : {"segments: [[0, 0, 1, 0]]", "resolution: 0.1\nname: x\npolygons: []",
                            "segmets: []",  // so that the reader can name the right key
                            "{segments: [[0, 0, 1, 0]]}", R"( {"type": "LineString"})"})
    EXPECT_TRUE(is_segment_text(walls, "a.yaml")) << walls;
  EXPECT_TRUE(is_segment_text("", "a.geojson"));
  EXPECT_TRUE(is_segment_text("", "a.json"));
  EXPECT_FALSE(is_segment_text("image: a.pgm\nresolution: 0.05\n", "a.yaml"));
  EXPECT_FALSE(is_segment_text("resolution: 0.05\nimage: a.pgm\n", "a.yaml"));
  EXPECT_FALSE(is_segment_text("imag: a.pgm\n", "a.yaml"));
  EXPECT_FALSE(is_segment_text(R"({"image": "a.pgm"})", "a.yaml"));
  EXPECT_FALSE(is_segment_text("P5\n1 1\n255\n", "a.pgm"));
  EXPECT_FALSE(is_segment_text("", "a.yaml"));
  EXPECT_FALSE(is_segment_text(std::string(100'000, '['), "a.yaml"));
}

TEST(SegmentMapKind, ReadMapTakesAll) {
  const TempFile yaml("walls.yaml", "segments: [[0, 0, 1, 0]]\n");
  const TempFile json("walls.geojson", R"({"type": "LineString", "coordinates": [[0, 0], [1, 0]]})");
  const GridMap from_yaml = read_map(yaml.path()), from_json = read_map(json.path());
  EXPECT_EQ(from_yaml.name, yaml.path());
  EXPECT_EQ(from_yaml.walls.size(), 1u);
  EXPECT_EQ(from_yaml.cells, from_json.cells);
  EXPECT_EQ(from_yaml.at_point(0.5, 0.0), Cell::occupied);
  EXPECT_EQ(from_yaml.at_point(0.5, 0.1), Cell::free);
}

// ---- placing ----------------------------------------------------------------------------------------------

TEST(PlacedSegments, WallsLieInTheFrameOfTheGrid) {
  const SegmentMap room = {"", 0.5, {{{-1.0, 5e6}, {3.0, 5e6}}, {{3.0, 5e6}, {3.0, 5e6 + 2}}}};
  const GridMap map = place_segments(room, "walls").map;
  // 3 cells of margin, and the walls' round coordinates on the middle of cells.
  EXPECT_EQ(map.T_map_grid.x_m, -1.0 - 3.5 * 0.5);
  EXPECT_EQ(map.T_map_grid.y_m, 5e6 - 3.5 * 0.5);
  EXPECT_EQ(map.width, 3 + 9 + 3);
  EXPECT_EQ(map.height, 3 + 5 + 3);
  EXPECT_EQ(map.walls[0].ax, 1.75f);
  EXPECT_EQ(map.walls[0].ay, 1.75f);
  EXPECT_EQ(map.walls[1].by, 3.75f);
  EXPECT_EQ(std::count(map.cells.begin(), map.cells.end(), Cell::occupied), 9 + 4);
}

TEST(PlacedSegments, ZeroLengthAndDuplicatesAreDroppedAndCounted) {
  const SegmentMap map = {"",
                          0.05,
                          {{{0, 0}, {1, 0}},
                           {{2, 2}, {2, 2}},
                           {{1, 0}, {0, 0}},
                           {{0, 0}, {1, 0}},
                           {{0, 0}, {1, 1e-9}},  // the same in the precision of a GridWall
                           {{1, 1}, {1, 1 + 1e-12}},
                           {{0, 0}, {0.5, 0}}}};  // a part of another, which is no duplicate
  const PlacedSegments placed = place_segments(map, "walls");
  EXPECT_EQ(placed.map.walls.size(), 2u);
  EXPECT_EQ(placed.zero_length, 2u);
  EXPECT_EQ(placed.duplicates, 3u);
}

TEST(PlacedSegments, TooLargeOrEmptyIsAnError) {
  const auto expect_error = [](const SegmentMap& map, const std::string& part) {
    expect_parts(error_of([&] { place_segments(map, "walls"); }), {part});
  };
  expect_error(
      {"", 0.05, {{{0, 0}, {2000, 0}}}},
      "walls: the walls span 2000 x 0 m, 40007 x 7 cells of 0.05 m: expected at most 32767 on a side");
  expect_error({"", 0.05, {{{0, 0}, {1000, 1000}}}}, "and 268435456 in all; give a coarser 'resolution'");
  expect_error({"", 1e-4, {{{-1e8, 0}, {1e8, 0}}}}, "coarser 'resolution'");
  expect_error({"", 0.05, {{{1, 1}, {1, 1}}}},
               "expected a segment that is longer than zero, found none in 1");
  expect_error({"", 0.05, {}}, "found none");
  EXPECT_NO_THROW(place_segments({"", 1.0, {{{0, 0}, {1000, 1000}}}}, "walls"));
}

}  // namespace
}  // namespace parloc
