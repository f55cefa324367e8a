// Segment maps: the YAML and GeoJSON readers, and the grid that is made of the walls.
#include "common/map/segment_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/map/map_reader.h"
#include "common/map/rasterise.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

using test::TempFile;

using Read = SegmentMap (*)(const std::string& text, const std::string& name);

/// The message of the input error that reading gives; empty (and a failure) if it gives none.
std::string error_of(Read read, const std::string& text) {
  try {
    read(text, "walls");
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::input) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    return e.what();
  }
  ADD_FAILURE() << "no error: " << text;
  return {};
}
std::string yaml_error(const std::string& text) {
  return error_of(segment_map_from_yaml, text);
}
std::string json_error(const std::string& text) {
  return error_of(segment_map_from_geojson, text);
}
void expect_part(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

/// "ax ay bx by" per line.
std::string text_of(const std::vector<WallLine>& lines) {
  std::string text;
  for (const WallLine& l : lines) {
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
    expect_part(yaml_error(c.text), c.part);
  }
}

TEST(SegmentYaml, AMillionSegmentsAreRead) {
  // One more than the limit as a polyline, which is quicker to read than as many segments.
  std::string text = "polylines:\n- [";
  for (std::size_t k = 0; k <= kMostSegments; ++k) text += k % 2 == 0 ? "[0,0]," : "[1,0],";
  EXPECT_EQ(segment_map_from_yaml(text + "]\n", "walls").lines.size(), kMostSegments);
  expect_part(yaml_error(text + "[2,2]]\n"), "polylines[0]: expected at most 1000000 segments, found more");
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
    expect_part(json_error(c.text), c.part);
  }
}

TEST(Geojson, DeepNestingIsAnErrorAndNoCrash) {
  std::string deep, close;
  for (int k = 0; k < 100'000; ++k) {
    deep += R"({"type":"GeometryCollection","geometries":[)";
    close += "]}";
  }
  expect_part(json_error(deep + close), "at most 16 collections");
  expect_part(json_error(R"({"type": "LineString", "coordinates": )" + std::string(200'000, '[') +
                         std::string(200'000, ']') + "}"),
              "expected a point");
  expect_part(json_error(std::string(200'000, '[')), "not valid JSON");
}

// ---- which kind of file ---------------------------------------------------------------------------------

TEST(SegmentMapKind, IsToldByContentAndEnding) {
  EXPECT_TRUE(is_segment_text("segments: [[0, 0, 1, 0]]", "a.yaml"));
  EXPECT_TRUE(is_segment_text("resolution: 0.1\nname: x\npolygons: []", "a.yaml"));
  EXPECT_TRUE(is_segment_text("segmets: []", "a.yaml"));  // so that the reader can name the right key
  EXPECT_TRUE(is_segment_text("{segments: [[0, 0, 1, 0]]}", "a.yaml"));
  EXPECT_TRUE(is_segment_text(R"( {"type": "LineString"})", "a.yaml"));
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
                           {{0, 0}, {1, 1e-9}},  // the same in the precision of a Segment
                           {{1, 1}, {1, 1 + 1e-12}},
                           {{0, 0}, {0.5, 0}}}};  // a part of another, which is no duplicate
  const PlacedSegments placed = place_segments(map, "walls");
  EXPECT_EQ(placed.map.walls.size(), 2u);
  EXPECT_EQ(placed.zero_length, 2u);
  EXPECT_EQ(placed.duplicates, 3u);
}

TEST(PlacedSegments, TooLargeOrEmptyIsAnError) {
  const auto error = [](const SegmentMap& map) {
    try {
      place_segments(map, "walls");
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      return std::string(e.what());
    }
    return std::string("none");
  };
  expect_part(
      error({"", 0.05, {{{0, 0}, {2000, 0}}}}),
      "walls: the walls span 2000 x 0 m, 40007 x 7 cells of 0.05 m: expected at most 32767 on a side");
  expect_part(error({"", 0.05, {{{0, 0}, {1000, 1000}}}}),
              "and 268435456 in all; give a coarser 'resolution'");
  expect_part(error({"", 1e-4, {{{-1e8, 0}, {1e8, 0}}}}), "coarser 'resolution'");
  expect_part(error({"", 0.05, {{{1, 1}, {1, 1}}}}),
              "expected a segment that is longer than zero, found none in 1");
  expect_part(error({"", 0.05, {}}), "found none");
  EXPECT_EQ(error({"", 1.0, {{{0, 0}, {1000, 1000}}}}), "none");
}

// ---- cells
// ---------------------------------------------------------------------------------------------------

/// How far the closed cell is from the segment, both in cells: 0 if they touch. By the separating axes: the
/// largest gap between their shadows on the axes and on the segment's normal.
double gap(double i, double j, const Segment& s) {
  const double dx = double{s.bx} - s.ax, dy = double{s.by} - s.ay, length = std::hypot(dx, dy);
  const double on_x = std::max(i - std::max(s.ax, s.bx), std::min(s.ax, s.bx) - (i + 1));
  const double on_y = std::max(j - std::max(s.ay, s.by), std::min(s.ay, s.by) - (j + 1));
  double low = 1e9, high = -1e9;  // shadow of the cell's corners, the segment's being 0
  for (const auto& [x, y] : {std::pair(i, j), {i + 1, j}, {i, j + 1}, {i + 1, j + 1}}) {
    const double across = dx * (y - s.ay) - dy * (x - s.ax);
    low = std::min(low, across), high = std::max(high, across);
  }
  return std::max({0.0, on_x, on_y, low / length, -high / length});
}

/// Cells of 1 m, so that metres are cells.
GridMap grid_of(std::int32_t width, std::int32_t height, std::vector<Segment> walls) {
  GridMap map;
  map.width = width, map.height = height, map.resolution_m = 1.0;
  map.walls = std::move(walls);
  map.cells.assign(static_cast<std::size_t>(width * height), Cell::free);
  return map;
}

void expect_supercover(const Segment& wall) {
  GridMap map = grid_of(24, 20, {wall});
  for_each_touched_cell(map, wall, [&](int i, int j) { map.cells[j * map.width + i] = Cell::occupied; });
  for (int j = 0; j < map.height; ++j) {
    for (int i = 0; i < map.width; ++i) {
      const double away = gap(i, j, wall);
      if (away == 0.0) {
        EXPECT_EQ(map.at(i, j), Cell::occupied) << i << ' ' << j;
      } else if (away > 2e-6) {
        EXPECT_EQ(map.at(i, j), Cell::free) << i << ' ' << j << " away " << away;
      }
    }
  }
}

TEST(Rasterise, EqualsBruteForceOnRandomSegments) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> x(2.0f, 22.0f), y(2.0f, 18.0f);
  for (int k = 0; k < 2000 && !HasFailure(); ++k)
    expect_supercover({x(random), y(random), x(random), y(random)});
}

TEST(Rasterise, EqualsBruteForceThroughCornersAndAlongEdges) {
  // Whole, half and quarter coordinates: touched corners and edges everywhere, and the brute force is exact.
  std::mt19937 random(12);
  for (const int parts : {1, 2, 4}) {
    std::uniform_int_distribution<int> x(2 * parts, 22 * parts), y(2 * parts, 18 * parts);
    for (int k = 0; k < 1000 && !HasFailure(); ++k) {
      const auto at = [&](auto& d) { return static_cast<float>(d(random)) / static_cast<float>(parts); };
      const Segment wall = {at(x), at(y), at(x), at(y)};
      if (wall.ax != wall.bx || wall.ay != wall.by) expect_supercover(wall);
    }
  }
  expect_supercover({3, 5, 17, 5});
  expect_supercover({3, 5, 3, 9});
  expect_supercover({3, 3, 9, 9});
  expect_supercover({9, 3, 3, 9});
}

TEST(Rasterise, ErrorIsThatOfTheFarthestCell) {
  std::mt19937 random(13);
  std::uniform_real_distribution<float> x(2.0f, 22.0f), y(2.0f, 18.0f);
  for (int k = 0; k < 50; ++k) {
    GridMap map = grid_of(
        24, 20, {{x(random), y(random), x(random), y(random)}, {x(random), y(random), x(random), y(random)}});
    rasterise_walls(map);
    double worst = 0.0;
    for (int j = 0; j < map.height; ++j) {
      for (int i = 0; i < map.width; ++i) {
        if (map.at(i, j) != Cell::occupied) continue;
        double nearest = 1e9;
        for (const Segment& s : map.walls) {
          for (int step = 0; step <= 2000; ++step) {
            const double t = step / 2000.0;
            nearest = std::min(
                nearest, std::hypot(s.ax + t * (s.bx - s.ax) - i - 0.5, s.ay + t * (s.by - s.ay) - j - 0.5));
          }
        }
        worst = std::max(worst, nearest);
      }
    }
    EXPECT_NEAR(raster_error_m(map), worst, 1e-3);  // steps of 1 cm on walls of 20 m: h^2 / 8 / 0.02 at most
    EXPECT_LE(raster_error_m(map), std::sqrt(0.5) + 1e-5);
  }
}

std::vector<Segment> ring(float x, float y, float width, float height) {
  return {{x, y, x + width, y},
          {x + width, y, x + width, y + height},
          {x + width, y + height, x, y + height},
          {x, y + height, x, y}};
}

TEST(Rasterise, OutsideOfAClosedRingIsUnknown) {
  GridMap map = grid_of(20, 16, ring(3.5f, 3.5f, 12, 8));
  EXPECT_TRUE(rasterise_walls(map));
  for (int j = 0; j < 16; ++j) {
    for (int i = 0; i < 20; ++i) {
      const bool inside = i > 3 && i < 15 && j > 3 && j < 11;
      const bool wall = !inside && i >= 3 && i <= 15 && j >= 3 && j <= 11;
      EXPECT_EQ(map.at(i, j), inside ? Cell::free : wall ? Cell::occupied : Cell::unknown) << i << ' ' << j;
    }
  }
}

TEST(Rasterise, ARingInARingIsFreeInside) {
  std::vector<Segment> walls = ring(3.5f, 3.5f, 12, 8);
  for (const Segment& wall : ring(6.5f, 6.5f, 4, 3)) walls.push_back(wall);
  GridMap map = grid_of(20, 16, walls);
  EXPECT_TRUE(rasterise_walls(map));
  EXPECT_EQ(map.at(4, 4), Cell::free);
  EXPECT_EQ(map.at(8, 8), Cell::free);
  EXPECT_EQ(map.at(6, 6), Cell::occupied);
  EXPECT_EQ(map.at(1, 8), Cell::unknown);
}

TEST(Rasterise, ADiagonalRingHoldsToo) {
  // Diagonal walls through the cells' corners: nothing leaks between them.
  GridMap map = grid_of(40, 40, {{20, 3, 37, 20}, {37, 20, 20, 37}, {20, 37, 3, 20}, {3, 20, 20, 3}});
  EXPECT_TRUE(rasterise_walls(map));
  EXPECT_EQ(map.at(20, 20), Cell::free);
  EXPECT_EQ(map.at(3, 3), Cell::unknown);
}

TEST(Rasterise, WithoutARingAllThatIsNotWallIsFree) {
  const auto no_unknown = [](std::vector<Segment> walls) {
    GridMap map = grid_of(40, 40, std::move(walls));
    EXPECT_FALSE(rasterise_walls(map));
    EXPECT_EQ(std::count(map.cells.begin(), map.cells.end(), Cell::unknown), 0);
    EXPECT_GT(std::count(map.cells.begin(), map.cells.end(), Cell::occupied), 0);
  };
  std::vector<Segment> court = ring(4.5f, 4.5f, 30, 30);
  court.pop_back();
  no_unknown(court);
  std::vector<Segment> court_with_pillar = court;
  for (const Segment& wall : ring(15.5f, 15.5f, 4, 4)) court_with_pillar.push_back(wall);
  no_unknown(court_with_pillar);
  // A court with a door whose walls have a thickness: only the inside of the walls is enclosed.
  std::vector<Segment> thick = ring(4.5f, 4.5f, 30, 2);
  for (const Segment& wall : ring(4.5f, 4.5f, 2, 30)) thick.push_back(wall);
  for (const Segment& wall : ring(32.5f, 4.5f, 2, 30)) thick.push_back(wall);
  no_unknown(thick);
}

}  // namespace
}  // namespace parloc
