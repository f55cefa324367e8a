// `parloc map` as a person or a script meets it: what it tells of a map, grids turned into walls and back,
// and what is wrong on the command line.
#include <gtest/gtest.h>

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
  expect_parts(done({"map", "info", path("room.yaml")}).out,
               {"60 x 40 cells, 6.00 x 4.00 m", "occupied    226 cells"});  // 196 around, 30 in the pillar
}

TEST_F(MapProgram, ConvertsBetweenGridsAndWalls) {
  const auto expect_told = [](const Args& args, std::initializer_list<std::string> parts) {
    expect_parts(done(with({"map"}, args)).out, parts);
  };
  expect_told({"convert", path("room.yaml"), path("walls.geojson"), "--picture", path("walls.png")},
              {"60 x 40 cells of 0.1 m, 226 occupied",
               "8 segments",  // four sides of the room, four of the pillar
               "8 straight runs of cell faces", "at most 0 m allowed, 0.0000 m measured"});
  expect_png(path("walls.png"));

  expect_told({"info", path("walls.geojson")},
              {"8 segments, ", "ring        closed", "walls span  x 0.10 to 5.90 m, y 0.10 to 3.90 m"});
  expect_told({"check", path("walls.geojson")}, {"sound, 8 segments"});
  expect_told({"show", path("walls.geojson"), "--out", path("shown.png")}, {});
  expect_png(path("shown.png"));

  expect_told({"convert", path("walls.geojson"), path("again.yaml"), "--resolution", "0.2"},
              {"cells of 0.2 m", "at most 0.1414 m from a wall"});
  const GridMap grid = read_map(path("again.yaml"));
  EXPECT_TRUE(grid.walls.empty());
  EXPECT_EQ(grid.resolution_m, 0.2);
  EXPECT_EQ(grid.at_point(0.1, 2.0), Cell::occupied);
  EXPECT_EQ(grid.at_point(1.0, 1.0), Cell::free);

  expect_told({"convert", path("walls.geojson"), path("walls.yaml"), "--to", "segments"}, {"the same"});
  EXPECT_EQ(read_map(path("walls.yaml")).walls.size(), 8u);
  expect_told({"convert", path("room.yaml"), path("rough.yaml"), "--max-error", "0.2"}, {"0.2 m allowed"});
}

TEST_F(MapProgram, CropsABorderOfUnknownThatItNames) {
  GridMap wide = room;
  wide.width = 800, wide.height = 500;
  wide.T_map_grid = {-30.0, -20.0, 0.5};
  wide.cells.assign(400'000, Cell::unknown);
  for (std::int32_t j = 0; j < room.height; ++j)
    for (std::int32_t i = 0; i < room.width; ++i)
      if (room.at(i, j) != Cell::unknown) wide.cells[wide.index(i + 300, j + 200)] = room.at(i, j);
  write_map(path("wide.yaml"), wide);
  expect_parts(
      done({"map", "check", path("wide.yaml")}).out,
      {"note: a border of unknown is 99 % of the cells and takes about 15 MB", "leaves 60 x 40 cells"});
  done({"map", "convert", path("wide.yaml"), path("cropped.yaml"), "--crop"});
  const GridMap cropped = read_map(path("cropped.yaml"));
  EXPECT_EQ(cropped.width, 62);
  EXPECT_EQ(cropped.height, 42);
  for (std::int32_t j = 0; j < wide.height; ++j) {
    for (std::int32_t i = 0; i < wide.width; ++i) {
      const Pose place = compose(wide.T_map_grid, {(i + 0.5) * 0.1, (j + 0.5) * 0.1, 0.0});
      ASSERT_EQ(cropped.at_point(place.x_m, place.y_m), wide.at(i, j)) << i << ", " << j;
    }
  }
  EXPECT_EQ(done({"map", "check", path("cropped.yaml")}).out,
            path("cropped.yaml") + ": sound, 62 x 42 cells\n");
}

TEST_F(MapProgram, NamesKeysThatAreNotUsed) {
  write_map(path("typed.yaml"), room);
  std::ofstream(path("typed.yaml"), std::ios::app) << "map_type: occupancy\nzones:\n  - {name: a}\n";
  for (const char* what : {"info", "check"})
    expect_parts(done({"map", what, path("typed.yaml")}).out, {"typed.yaml:8: the key 'map_type' is not used",
                                                               "typed.yaml:9: the key 'zones' is not used"});
}

TEST_F(MapProgram, MapErrorsAreOneLine) {
  write("odd.yaml", "segments: [[0, 0, 1, 0], [1, 0, 0, 0], [2, 2, 2, 2]]\n");
  expect_parts(done({"map", "check", path("odd.yaml")}).out,
               {"1 of zero length, 1 duplicate left out", "no closed ring"});
  write("broken.yaml", "segments:\n  - [0, 0, 1]\n");
  write("point.geojson", R"({"type": "Point", "coordinates": [0, 0]})");
  GridMap solid = room;
  solid.cells.assign(solid.cells.size(), Cell::occupied);
  write_map(path("solid.yaml"), solid);
  fs::create_directories(path("taken.yaml/inside"));
  const auto convert = [](const std::string& in, const std::string& out, const Args& more = {}) {
    return with({"map", "convert", path(in), path(out)}, more);
  };
  const ProgramCase cases[] = {
      {{"map", "check", path("broken.yaml")}, 3, "broken.yaml:2: segments[0]: expected 4 numbers"},
      {{"map", "check", path("point.geojson")}, 3, "found 'Point'"},
      {{"map", "check", path("solid.yaml")}, 3, "expected a free cell"},
      {{"map", "info", path("none.geojson")}, 3, "cannot be opened"},
      {convert("solid.yaml", "o.yaml"), 3, "expected a wall to trace"},
      {convert("odd.yaml", "odd.yaml"), 2, "OUT is the file that IN is"},
      {convert("odd.yaml", "o.geojson", {"--to", "grid"}), 2, "such as map.yaml"},
      {convert("odd.yaml", "o.yaml", {"--max-error", "1"}), 2, "for a grid only"},
      {convert("odd.yaml", "o.yaml", {"--resolution", "nan"}), 2, "--resolution: expected a number"},
      {convert("odd.yaml", "o.yaml", {"--resolution", "0.0001"}), 3, "coarser 'resolution'"},
      {convert("room.yaml", "o.yaml", {"--resolution", "1"}), 2, "for segments only"},
      {convert("room.yaml", "o.yaml", {"--max-error", "-1"}), 2, "--max-error: expected a number"},
      {convert("room.yaml", "o.yaml", {"--to", "grid"}), 2, "is a grid already"},
      {convert("odd.yaml", "o.yaml", {"--crop"}), 2, "--crop makes a grid of a grid"},
      {convert("room.yaml", "o.geojson", {"--crop"}), 2, "--crop makes a grid of a grid"},
      {convert("room.yaml", "o.yaml", {"--crop", "--max-error", "1"}), 2, "it takes no other option"},
      {convert("room.yaml", "no/such/o.yaml"), 5, "cannot be written"},
      {convert("odd.yaml", "taken.yaml"), 5, "taken.yaml: cannot be written"},
      {convert("room.yaml", "o.shp"), 2, "expected OUT to end in .yaml"},
      {convert("room.yaml", "o"), 2, "expected OUT to end in .yaml"},
      {convert("odd.yaml", "o.png"), 2, "such as map.yaml"},
      {convert("room.yaml", "o.yaml", {"--picture", path("no/such/p.png")}), 5, "cannot be written"},
      {{"map", "show", path("room.yaml"), "--out", path("no/such/p.png")}, 5, "cannot be written"},
      {{"map", "show", path("room.yaml")}, 2, "--out"},
  };
  for (const ProgramCase& c : cases) expect_error(call(c.args), c);
  for (const char* left : {"o", "o.yaml", "o.pgm", "o.png", "o.shp", "o.geojson", "taken.pgm"})
    EXPECT_FALSE(fs::exists(path(left))) << left;
}

}  // namespace
}  // namespace parloc::test
