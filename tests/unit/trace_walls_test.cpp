// Cells -> walls, walls with fewer points, and segment files that are written and read again.
#include "common/map/trace_walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "common/map/map_reader.h"
#include "common/map/segment_map.h"
#include "common/map/simplify.h"
#include "tests/unit/expect.h"
#include "tests/unit/map_t1.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

using test::map_t1, test::TempFile;

GridMap random_grid(std::mt19937& random, int width, int height, double density) {
  std::vector<std::string> rows(static_cast<std::size_t>(height),
                                std::string(static_cast<std::size_t>(width), '.'));
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  for (std::string& row : rows) {
    for (char& c : row) c = chance(random) < density ? '#' : chance(random) < 0.1 ? '?' : '.';
  }
  return grid_from_text(rows, 0.25);
}

using Face = std::array<int, 4>;  // from corner (x, y) to the corner right of it or above it

std::multiset<Face> faces_of_cells(const GridMap& map, bool unknown_blocks) {
  const auto blocks = [&](int i, int j) {
    return map.at(i, j) == Cell::occupied || (unknown_blocks && map.at(i, j) == Cell::unknown);
  };
  std::multiset<Face> faces;
  for (int j = 0; j < map.height; ++j) {
    for (int i = 0; i < map.width; ++i) {
      if (i > 0 && blocks(i, j) != blocks(i - 1, j)) faces.insert({i, j, i, j + 1});
      if (j > 0 && blocks(i, j) != blocks(i, j - 1)) faces.insert({i, j, i + 1, j});
    }
  }
  return faces;
}

std::multiset<Face> faces_of_walls(const std::vector<GridWall>& walls, double resolution_m) {
  std::multiset<Face> faces;
  const auto corner = [&](float metres) { return static_cast<int>(std::lround(metres / resolution_m)); };
  for (const GridWall& w : walls) {
    const int x0 = corner(std::min(w.ax, w.bx)), x1 = corner(std::max(w.ax, w.bx));
    const int y0 = corner(std::min(w.ay, w.by)), y1 = corner(std::max(w.ay, w.by));
    EXPECT_TRUE((x0 == x1) != (y0 == y1));
    for (int x = x0; x < x1; ++x) faces.insert({x, y0, x + 1, y0});
    for (int y = y0; y < y1; ++y) faces.insert({x0, y, x0, y + 1});
  }
  return faces;
}

/// No wall goes on where another one ends, in the same direction.
bool merged(const std::vector<GridWall>& walls) {
  for (const GridWall& a : walls) {
    for (const GridWall& b : walls) {
      const bool follows = a.bx == b.ax && a.by == b.ay;
      const float cross = (a.bx - a.ax) * (b.by - b.ay) - (a.by - a.ay) * (b.bx - b.ax);
      const float along = (a.bx - a.ax) * (b.bx - b.ax) + (a.by - a.ay) * (b.by - b.ay);
      if (follows && cross == 0.0f && along > 0.0f) return false;
    }
  }
  return true;
}

TEST(TraceWalls, SmallMapHasTwelve) {
  const TracedWalls traced = trace_walls(map_t1());
  EXPECT_EQ(traced.walls.size(), 12u);
  EXPECT_EQ(traced.faces, 12u);
  EXPECT_EQ(traced.error_m, 0.0);
  // The room's lower side, from corner to corner.
  const auto lower = std::count_if(traced.walls.begin(), traced.walls.end(), [](const GridWall& w) {
    return w.ay == 0.5f && w.by == 0.5f && std::min(w.ax, w.bx) == 0.5f && std::max(w.ax, w.bx) == 4.5f;
  });
  EXPECT_EQ(lower, 1);
}

TEST(TraceWalls, EveryFaceIsTracedOnce) {
  std::mt19937 random(5);
  for (const double density : {0.05, 0.3, 0.5, 0.8, 1.0}) {
    for (int k = 0; k < 40 && !HasFailure(); ++k) {
      const GridMap map = random_grid(random, 1 + k % 17, 1 + k % 13, density);
      for (const bool unknown_blocks : {false, true}) {
        const TracedWalls traced = trace_walls(map, 0.0, unknown_blocks);
        EXPECT_EQ(faces_of_walls(traced.walls, 0.25), faces_of_cells(map, unknown_blocks));
        EXPECT_TRUE(merged(traced.walls));
      }
    }
  }
}

TEST(TraceWalls, BlocksThatMeetAtACornerAreOneThing) {
  const TracedWalls traced = trace_walls(grid_from_text({"....", ".#..", "..#.", "...."}, 1.0));
  ASSERT_EQ(traced.walls.size(), 8u);
  for (std::size_t k = 1; k < 8; ++k) {  // one chain around both
    EXPECT_EQ(traced.walls[k].ax, traced.walls[k - 1].bx);
    EXPECT_EQ(traced.walls[k].ay, traced.walls[k - 1].by);
  }
}

TEST(TraceWalls, TheRimIsNoFace) {
  EXPECT_TRUE(trace_walls(grid_from_text({"###", "###"}, 1.0)).walls.empty());
  EXPECT_TRUE(trace_walls(grid_from_text({"...", "..."}, 1.0)).walls.empty());
  EXPECT_EQ(trace_walls(grid_from_text({"#.", "#."}, 1.0)).walls.size(), 1u);
}

// ---- simplified walls ---------------------------------------------------------------------------------

double distance(double x, double y, const GridWall& s) {
  const double dx = double{s.bx} - s.ax, dy = double{s.by} - s.ay;
  const double t = std::clamp(((x - s.ax) * dx + (y - s.ay) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return std::hypot(x - s.ax - t * dx, y - s.ay - t * dy);
}

/// The largest distance of a point of `from`, sampled every 2 cm and at both ends, to the nearest of `to`.
double farthest(const std::vector<GridWall>& from, const std::vector<GridWall>& to) {
  double worst = 0.0;
  for (const GridWall& s : from) {
    const int steps = 1 + static_cast<int>(std::hypot(s.bx - s.ax, s.by - s.ay) / 0.02);
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      const double x = s.ax + t * (s.bx - s.ax), y = s.ay + t * (s.by - s.ay);
      double nearest = 1e9;
      for (const GridWall& other : to) nearest = std::min(nearest, distance(x, y, other));
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

/// A tilted room with round pillars and a few single cells, 60 x 60 cells of 0.1 m.
GridMap tilted_room() {
  std::vector<std::string> rows(60, std::string(60, '.'));
  for (int j = 0; j < 60; ++j) {
    for (int i = 0; i < 60; ++i) {
      const double x = 0.9 * (i - 30) + 0.43 * (j - 30), y = 0.9 * (j - 30) - 0.43 * (i - 30);
      const bool pillar = std::hypot(x - 8, y + 5) < 5 || std::hypot(x + 10, y - 8) < 3;
      if (std::max(std::fabs(x), std::fabs(y)) > 22 || pillar || (i * 7 + j * 13) % 211 == 0)
        rows[j][i] = '#';
    }
  }
  return grid_from_text(rows, 0.1);
}

TEST(TraceWalls, SimplifiedWallsStayWithinTheStatedError) {
  const GridMap map = tilted_room();
  const TracedWalls exact = trace_walls(map);
  std::size_t before = exact.walls.size();
  for (const double allowed_m : {0.03, 0.08, 0.15, 0.5}) {
    const TracedWalls walls = trace_walls(map, allowed_m);
    EXPECT_EQ(walls.faces, exact.walls.size());
    EXPECT_LE(walls.error_m, allowed_m);
    constexpr double kRounding = 1e-6;  // of float coordinates up to 6 m
    EXPECT_LE(farthest(exact.walls, walls.walls), walls.error_m + kRounding) << allowed_m;
    EXPECT_LE(farthest(walls.walls, exact.walls), walls.error_m + kRounding) << allowed_m;
    EXPECT_LE(walls.walls.size(), before) << allowed_m;
    before = walls.walls.size();
  }
  EXPECT_LT(trace_walls(map, 0.08).walls.size(), exact.walls.size() / 2);
  // The measured error is no mere bound: a wall is that far off somewhere.
  const TracedWalls some = trace_walls(map, 0.15);
  EXPECT_GT(farthest(exact.walls, some.walls), 0.5 * some.error_m);
}

TEST(TraceWalls, NothingVanishes) {
  const TracedWalls traced = trace_walls(grid_from_text({".....", ".#...", ".....", "...##"}, 0.1), 10.0);
  EXPECT_EQ(traced.walls.size(), 2u);  // the block's diagonal, and one line for what touches the rim
  for (const GridWall& w : traced.walls) EXPECT_GT(std::hypot(w.bx - w.ax, w.by - w.ay), 0.09);
}

TEST(TraceWalls, ANegativeErrorIsRefused) {
  EXPECT_THROW(trace_walls(map_t1(), -0.1), Error);
  EXPECT_THROW(trace_walls(map_t1(), NAN), Error);
}

TEST(Simplify, KeepsWhatItMust) {
  const std::vector<ChainPoint> stairs = {{0, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 2}, {3, 2}, {3, 3}};
  EXPECT_EQ(simplify(stairs, 0.0).kept.size(), 7u);
  EXPECT_GT(simplify(stairs, 0.70).kept.size(), 2u);
  EXPECT_EQ(simplify(stairs, 0.71).kept.size(), 2u);
  EXPECT_NEAR(simplify(stairs, 0.71).error, std::sqrt(0.5), 1e-15);
  // A spike beyond the ends: measured to the line between them, not to the infinite one.
  const std::vector<ChainPoint> spike = {{0, 0}, {5, 0}, {1, 0}};
  EXPECT_EQ(simplify(spike, 1.0).kept.size(), 3u);
  EXPECT_EQ(simplify({{0, 0}, {1, 1}}, 9.0).kept.size(), 2u);
  EXPECT_EQ(simplify({{0, 0}, {1, 0}, {1, 1}, {0, 0}}, 9.0).kept.size(), 3u);
}

// ---- files --------------------------------------------------------------------------------------------

std::multiset<Face> rounded(const std::vector<GridWall>& walls) {
  std::multiset<Face> all;
  for (const GridWall& w : walls) {
    const auto mm = [](float m) { return static_cast<int>(std::lround(1000.0 * m)); };
    Face face = {mm(w.ax), mm(w.ay), mm(w.bx), mm(w.by)};
    if (std::pair(face[2], face[3]) < std::pair(face[0], face[1]))
      face = {face[2], face[3], face[0], face[1]};
    all.insert(face);
  }
  return all;
}

std::multiset<std::array<float, 4>> exactly(const std::vector<GridWall>& walls) {
  std::multiset<std::array<float, 4>> all;
  for (const GridWall& w : walls) all.insert({w.ax, w.ay, w.bx, w.by});
  return all;
}

void expect_round_trip(const GridMap& map) {
  for (const char* ending : {"walls.yaml", "walls.geojson"}) {
    const TempFile file(ending);
    write_segment_map(file.path(), map);
    const GridMap back = read_map(file.path());
    EXPECT_EQ(exactly(back.walls), exactly(map.walls)) << ending;
    expect_equal(back.T_map_grid, map.T_map_grid);
    EXPECT_EQ(back.resolution_m, map.resolution_m);
    EXPECT_EQ(back.cells, map.cells);
    const TempFile again(ending);
    write_segment_map(again.path(), back);
    EXPECT_EQ(test::content_of(again.path()), test::content_of(file.path()));
  }
}

TEST(SegmentFiles, WrittenMapsReadBackBitForBit) {
  std::mt19937 random(21);
  for (const double scale_m : {1.0, 40.0, 700.0}) {
    for (const double far_m : {0.0, -3e5}) {
      std::uniform_real_distribution<double> at(far_m - scale_m, far_m + scale_m);
      SegmentMap map;
      map.resolution_m = scale_m / 100;
      MapPoint pen = {at(random), at(random)};
      for (int k = 0; k < 60; ++k) {  // chains of one to four walls
        const MapPoint next = {at(random), at(random)};
        map.lines.push_back({pen, next});
        pen = k % 7 < 3 ? next : MapPoint{at(random), at(random)};
      }
      expect_round_trip(place_segments(map, "walls").map);
    }
  }
}

TEST(SegmentFiles, RoundNumbersStayRound) {
  const GridMap map =
      place_segments(
          segment_map_from_yaml(
              "resolution: 0.1\nsegments:\n  - [0.1, -45.3, 812.7, 0]\npolylines:\n"
              "  - [[1.05, 2], [3, 4.25], [7, 7]]\npolygons:\n  - [[0, 0], [4.4, 0], [4.4, 3.3]]\n",
              "walls"),
          "walls")
          .map;
  EXPECT_EQ(
      segment_yaml_of(map),
      "# Walls in metres, map frame.\nresolution: 0.1\nsegments:\n  - [0.1, -45.3, 812.7, 0]\npolylines:\n"
      "  - [[1.05, 2], [3, 4.25], [7, 7]]\npolygons:\n  - [[0, 0], [4.4, 0], [4.4, 3.3]]\n");
  EXPECT_EQ(geojson_of(map),
            R"({"type": "FeatureCollection", "resolution": 0.1, "features": [
{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[0.1, -45.3], [812.7, 0]]}},
{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[1.05, 2], [3, 4.25], [7, 7]]}},
{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [4.4, 0], [4.4, 3.3], [0, 0]]]}}
]}
)");
}

TEST(SegmentFiles, TracedWallsOfATurnedGridLandWhereTheyWere) {
  GridMap map = map_t1();
  map.T_map_grid = {3.0, -7.0, 0.3};
  map.walls = trace_walls(map).walls;
  const TempFile file("walls.yaml");
  write_segment_map(file.path(), map);
  const GridMap back = read_map(file.path());
  GridMap turned = map;  // the walls that were read, in the frame of the old grid
  turned.walls.clear();
  for (const GridWall& w : back.walls) {
    const Pose a = relative(compose(back.T_map_grid, {w.ax, w.ay, 0}), map.T_map_grid);
    const Pose b = relative(compose(back.T_map_grid, {w.bx, w.by, 0}), map.T_map_grid);
    turned.walls.push_back({static_cast<float>(a.x_m), static_cast<float>(a.y_m), static_cast<float>(b.x_m),
                            static_cast<float>(b.y_m)});
  }
  EXPECT_EQ(rounded(turned.walls), rounded(map.walls));  // to a millimetre
}

TEST(SegmentFiles, NamesSurviveWhateverTheyAre) {
  const GridMap map = place_segments({"", 0.05, {{{0, 0}, {1, 0}}}}, "walls").map;
  for (const std::string name : {"room 7", "a: \"b\" # \\ {c}\n\x01", "caf\xC3\xA9", "{"}) {
    EXPECT_EQ(segment_map_from_yaml(segment_yaml_of(map, name), "walls").name, name);
    EXPECT_EQ(segment_map_from_geojson(geojson_of(map, name), "walls").name, name);
  }
}

TEST(SegmentFiles, AMapWithoutWallsIsNotWritten) {
  error_of([] { segment_yaml_of(map_t1()); }, ErrorKind::output);
}

}  // namespace
}  // namespace parloc
