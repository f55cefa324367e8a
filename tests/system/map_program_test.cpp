// `parloc map` as a person or a script meets it: what it tells of a map, grids turned into walls and back,
// and what is wrong on the command line.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/map/map_reader.h"
#include "tests/system/program_fixture.h"
#include "tests/unit/small_drive.h"

namespace parloc::test {
namespace {

namespace fs = std::filesystem;

class MapProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_map_test");
    room = small_room();
    write_map(path("room.yaml"), room);
  }
  static inline GridMap room;
};

TEST_F(MapProgram, TellsAboutAMap) {
  const Outcome info = call({"map", "info", path("room.yaml")});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_NE(info.out.find("60 x 40 cells, 6.00 x 4.00 m"), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("occupied    226 cells"), std::string::npos)
      << info.out;  // 196 around, 30 in the pillar
}

TEST_F(MapProgram, ConvertsBetweenGridsAndWalls) {
  const auto has = [](const Outcome& outcome, const std::string& part) {
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find(part), std::string::npos) << "'" << part << "' in\n" << outcome.out;
  };
  const Outcome traced =
      call({"map", "convert", path("room.yaml"), path("walls.geojson"), "--picture", path("walls.png")});
  has(traced, "60 x 40 cells of 0.1 m, 226 occupied");
  has(traced, "8 segments");  // four sides of the room, four of the pillar
  has(traced, "8 straight runs of cell faces");
  has(traced, "at most 0 m allowed, 0.0000 m measured");
  EXPECT_EQ(read_file(path("walls.png")).substr(1, 3), "PNG");

  const Outcome info = call({"map", "info", path("walls.geojson")});
  has(info, "8 segments, ");
  has(info, "ring        closed");
  has(info, "walls span  x 0.10 to 5.90 m, y 0.10 to 3.90 m");
  has(call({"map", "check", path("walls.geojson")}), "sound, 8 segments");
  has(call({"map", "show", path("walls.geojson"), "--out", path("shown.png")}), "");
  EXPECT_EQ(read_file(path("shown.png")).substr(1, 3), "PNG");

  const Outcome back =
      call({"map", "convert", path("walls.geojson"), path("again.yaml"), "--resolution", "0.2"});
  has(back, "cells of 0.2 m");
  has(back, "at most 0.1414 m from a wall");
  const GridMap grid = read_map(path("again.yaml"));
  EXPECT_TRUE(grid.walls.empty());
  EXPECT_EQ(grid.resolution_m, 0.2);
  EXPECT_EQ(grid.at_point(0.1, 2.0), Cell::occupied);
  EXPECT_EQ(grid.at_point(1.0, 1.0), Cell::free);

  has(call({"map", "convert", path("walls.geojson"), path("walls.yaml"), "--to", "segments"}), "the same");
  EXPECT_EQ(read_map(path("walls.yaml")).walls.size(), 8u);
  has(call({"map", "convert", path("room.yaml"), path("rough.yaml"), "--max-error", "0.2"}), "0.2 m allowed");
}

TEST_F(MapProgram, MapErrorsAreOneLine) {
  write_file(path("odd.yaml"), "segments: [[0, 0, 1, 0], [1, 0, 0, 0], [2, 2, 2, 2]]\n");
  const Outcome odd = call({"map", "check", path("odd.yaml")});
  EXPECT_EQ(odd.code, 0) << odd.err;
  EXPECT_NE(odd.out.find("1 of zero length, 1 duplicate left out"), std::string::npos) << odd.out;
  EXPECT_NE(odd.out.find("no closed ring"), std::string::npos) << odd.out;
  write_file(path("broken.yaml"), "segments:\n  - [0, 0, 1]\n");
  write_file(path("point.geojson"), R"({"type": "Point", "coordinates": [0, 0]})");
  GridMap solid = room;
  solid.cells.assign(solid.cells.size(), Cell::occupied);
  write_map(path("solid.yaml"), solid);
  fs::create_directories(path("taken.yaml/inside"));
  const ProgramCase cases[] = {
      {{"map", "check", path("broken.yaml")}, 3, "broken.yaml:2: segments[0]: expected 4 numbers"},
      {{"map", "check", path("point.geojson")}, 3, "found 'Point'"},
      {{"map", "check", path("solid.yaml")}, 3, "expected a free cell"},
      {{"map", "info", path("none.geojson")}, 3, "cannot be opened"},
      {{"map", "convert", path("solid.yaml"), path("o.yaml")}, 3, "expected a wall to trace"},
      {{"map", "convert", path("odd.yaml"), path("odd.yaml")}, 2, "OUT is the file that IN is"},
      {{"map", "convert", path("odd.yaml"), path("o.geojson"), "--to", "grid"}, 2, "such as map.yaml"},
      {{"map", "convert", path("odd.yaml"), path("o.yaml"), "--max-error", "1"}, 2, "for a grid only"},
      {{"map", "convert", path("odd.yaml"), path("o.yaml"), "--resolution", "nan"},
       2,
       "--resolution: expected a number"},
      {{"map", "convert", path("odd.yaml"), path("o.yaml"), "--resolution", "0.0001"},
       3,
       "coarser 'resolution'"},
      {{"map", "convert", path("room.yaml"), path("o.yaml"), "--resolution", "1"}, 2, "for segments only"},
      {{"map", "convert", path("room.yaml"), path("o.yaml"), "--max-error", "-1"},
       2,
       "--max-error: expected a number"},
      {{"map", "convert", path("room.yaml"), path("o.yaml"), "--to", "grid"}, 2, "is a grid already"},
      {{"map", "convert", path("room.yaml"), path("no/such/o.yaml")}, 5, "cannot be written"},
      {{"map", "convert", path("odd.yaml"), path("taken.yaml")}, 5, "taken.yaml: cannot be written"},
      {{"map", "convert", path("room.yaml"), path("o.shp")}, 2, "expected OUT to end in .yaml"},
      {{"map", "convert", path("room.yaml"), path("o")}, 2, "expected OUT to end in .yaml"},
      {{"map", "convert", path("odd.yaml"), path("o.png")}, 2, "such as map.yaml"},
      {{"map", "convert", path("room.yaml"), path("o.yaml"), "--picture", path("no/such/p.png")},
       5,
       "cannot be written"},
      {{"map", "show", path("room.yaml"), "--out", path("no/such/p.png")}, 5, "cannot be written"},
      {{"map", "show", path("room.yaml")}, 2, "--out"},
  };
  for (const ProgramCase& c : cases) expect_error(call(c.args), c);
  for (const char* left : {"o", "o.yaml", "o.pgm", "o.png", "o.shp", "o.geojson", "taken.pgm"})
    EXPECT_FALSE(fs::exists(path(left))) << left;
}

}  // namespace
}  // namespace parloc::test
