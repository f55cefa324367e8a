// Maps as a whole: what a pixel becomes in each mode, and writing a map that reads back.
#include "common/map/map_reader.h"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "common/map/map_yaml.h"
#include "tests/unit/expect.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

namespace fs = std::filesystem;

/// A folder that is gone after the test.
class MapFolder : public ::testing::Test {
 protected:
  MapFolder() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("parloc_" + std::to_string(getpid()) + "_" + info->name());
    fs::create_directories(folder_);
  }
  ~MapFolder() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }

  fs::path folder_;
};

std::string yaml_with(const std::string& mode_and_negate, const std::string& image = "map.pgm",
                      const std::string& origin = "[-1.5, 2, 0]") {
  return "image: " + image + "\nresolution: 0.05\norigin: " + origin +
         "\noccupied_thresh: 0.65\nfree_thresh: 0.196\n" + mode_and_negate;
}

std::string pgm(int width, int height, const std::vector<int>& values) {
  std::string bytes = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  for (const int v : values) bytes += static_cast<char>(v);
  return bytes;
}

/// '#', '.', '?' per cell, row j = 0 first.
std::string picture(const GridMap& map) {
  std::string out;
  for (const Cell c : map.cells) out += c == Cell::occupied ? '#' : c == Cell::free ? '.' : '?';
  return out;
}

// ---- pixels to cells ----------------------------------------------------------------------------

class MapModes : public MapFolder {
 protected:
  GridMap read(const std::vector<int>& values, const std::string& mode_and_negate) const {
    write("map.pgm", pgm(static_cast<int>(values.size()), 1, values));
    return read_map(write("map.yaml", yaml_with(mode_and_negate)));
  }
};

// SPEC 0.2: 205 gives p = 0.196078 > 0.196, unknown. 255 - 166 = 89 -> p = 0.349; 89 -> p = 0.6510 > 0.65; 90
// -> 0.647.
TEST_F(MapModes, Trinary) {
  EXPECT_EQ(picture(read({205, 254, 0, 206, 90, 89, 255}, "negate: 0")), "?.#.?#.");
}

// nav2 asks "occupied_thresh < 1 - shade", then "1 - shade < free_thresh", in double precision: a tie is
// unknown, but 1 - 204/255 is a hair below 0.2, as 1 - 153/255 is 0.4 exactly.
TEST_F(MapModes, TiesAtTheThresholds) {
  const auto cells = [&](const std::string& thresholds, const std::string& more) {
    write("map.pgm", pgm(4, 1, {204, 203, 153, 102}));
    return picture(read_map(
        write("map.yaml", "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n" + thresholds + more)));
  };
  EXPECT_EQ(cells("occupied_thresh: 0.4\nfree_thresh: 0.2\n", "negate: 0\n"), ".??#");
  EXPECT_EQ(cells("occupied_thresh: 0.8\nfree_thresh: 0.4\n", "negate: 1\n"), "????");
  EXPECT_EQ(cells("occupied_thresh: 0.4\nfree_thresh: 0.4\n", "negate: 0\n"), "..?#");
  EXPECT_EQ(cells("occupied_thresh: 0.5\nfree_thresh: 0.5\n", "negate: 0\n"), "...#");
}

TEST_F(MapModes, NegateSwapsBlackAndWhite) {
  EXPECT_EQ(picture(read({50, 1, 255, 49, 165, 166, 0}, "negate: 1")), "?.#.?#.");
}

TEST_F(MapModes, ScaleOfAnOpaqueImageIsTrinary) {
  EXPECT_EQ(picture(read({205, 254, 0, 206, 90, 89, 255}, "negate: 0\nmode: scale")), "?.#.?#.");
}

TEST_F(MapModes, RawIsPercentAndIgnoresNegate) {
  const std::vector<int> values{0, 19, 20, 65, 66, 100, 101, 255};
  EXPECT_EQ(picture(read(values, "negate: 0\nmode: raw")), "..??##??");
  EXPECT_EQ(picture(read(values, "negate: 1\nmode: raw")), "..??##??");
}

// As in nav2: trinary takes alpha as a fourth colour, so an opaque 205 (mean 217.5) is free there; in scale
// whatever is not opaque is unknown; raw ignores alpha.
TEST_F(MapFolder, AlphaInEachMode) {
  const std::vector<std::uint8_t> grey_alpha{0, 255, 255, 255, 205, 255, 255, 0, 0, 0, 100, 254};
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(grey_alpha.size() / 2);
  image.height = 1;
  image.format = PNG_FORMAT_GA;
  ASSERT_NE(png_image_write_to_file(&image, path("map.png").c_str(), 0, grey_alpha.data(), 0, nullptr), 0);
  const auto cells = [&](const std::string& mode) {
    return picture(read_map(write("map.yaml", yaml_with("negate: 0\nmode: " + mode, "map.png"))));
  };
  EXPECT_EQ(cells("trinary"), "#..?#?");
  EXPECT_EQ(cells("scale"), "#.????");
  EXPECT_EQ(cells("raw"), ".???.#");
}

// Colours are averaged before anything is rounded: 205, 205, 206 is 205.33, free below 0.196; 0, 76, 76 and
// alpha 255 are 101.75, occupied above 0.6; 89, 89, 90 is 89.33, not occupied at 0.65 as 89 is.
TEST_F(MapFolder, ColoursAreAveragedBeforeTheThreshold) {
  const auto cells = [&](const std::string& thresholds) {
    return picture(read_map(
        write("map.yaml", "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n" + thresholds)));
  };
  const auto write_png = [&](png_uint_32 format, int width, const auto& values) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = 1;
    image.format = format;
    ASSERT_NE(png_image_write_to_file(&image, path("map.png").c_str(), 0, values.data(), 0, nullptr), 0);
  };
  const std::string usual = "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
  write_png(PNG_FORMAT_RGB, 4,
            std::vector<std::uint8_t>{205, 205, 205, 205, 205, 206, 89, 89, 90, 90, 90, 89});
  EXPECT_EQ(cells(usual), "?.??");
  EXPECT_EQ(cells("occupied_thresh: 0.65\nfree_thresh: 0.19\n"), "????");
  write_png(PNG_FORMAT_RGBA, 3, std::vector<std::uint8_t>{0, 76, 76, 255, 0, 77, 76, 255, 51, 51, 51, 255});
  EXPECT_EQ(cells("occupied_thresh: 0.6\nfree_thresh: 0.1\n"), "#??");
}

// 52557 of 65535 is unknown and 52700 free, where both are 205 with 8 bits.
TEST_F(MapModes, SixteenBitsAreKept) {
  const auto cells = [&](const std::string& pixels) {
    write("map.pgm", "P2 4 1 " + pixels);
    return picture(read_map(write("map.yaml", yaml_with("negate: 0"))));
  };
  EXPECT_EQ(cells("65535 52557 52700 22930 22945"), "?.#?");  // 1 - 22930 / 65535 = 0.65011
  EXPECT_EQ(cells("1000 804 805 349 351"), "?.#?");
}

TEST_F(MapFolder, TheTopRowOfTheImageIsTheLastRowOfTheGrid) {
  write("map.pgm", pgm(2, 3, {0, 254, 205, 205, 254, 254}));
  const GridMap map = read_map(write("map.yaml", yaml_with("negate: 0")));
  EXPECT_EQ(map.width, 2);
  EXPECT_EQ(map.height, 3);
  EXPECT_EQ(picture(map), "..??#.");
  EXPECT_EQ(map.resolution_m, 0.05);
  EXPECT_EQ(map.T_map_grid.x_m, -1.5);
  EXPECT_EQ(map.T_map_grid.y_m, 2.0);
  EXPECT_EQ(map.name, path("map.yaml"));
}

// ---- files --------------------------------------------------------------------------------------

TEST_F(MapFolder, TheImageLiesRelativeToTheYamlOrIsAbsolute) {
  fs::create_directories(folder_ / "images");
  write("images/floor.pgm", pgm(1, 1, {0}));
  EXPECT_EQ(picture(read_map(write("a.yaml", yaml_with("negate: 0", "images/floor.pgm")))), "#");
  EXPECT_EQ(picture(read_map(write("b.yaml", yaml_with("negate: 0", path("images/floor.pgm"))))), "#");
}

TEST_F(MapFolder, FilesThatCannotBeRead) {
  const auto message = [&](const std::string& file) { return error_of([&] { read_map(file); }); };
  EXPECT_EQ(message(path("none.yaml")), path("none.yaml") + ": cannot be opened: No such file or directory");
  EXPECT_EQ(message(folder_.string()), folder_.string() + ": cannot be read: expected a file");
  const std::string lost = write("lost.yaml", "\n" + yaml_with("negate: 0", "none.pgm"));
  EXPECT_EQ(message(lost),
            lost + ":2: image " + path("none.pgm") + ": cannot be opened: No such file or directory");
  const std::string odd = write("odd.yaml", yaml_with("negate: 0", "odd.jpg"));
  write("odd.jpg", "\xff\xd8\xff");
  EXPECT_EQ(message(odd), path("odd.jpg") + ": expected a PGM (P2 or P5), a PNG or a BMP image");
  const std::string cut = write("cut.yaml", yaml_with("negate: 0", "cut.pgm"));
  write("cut.pgm", "P5 2 2 255\n123");
  EXPECT_EQ(message(cut),
            path("cut.pgm") + ": truncated: expected 4 bytes of pixels (2 x 2, maxval 255), found 3");
  EXPECT_EQ(message(path("cut.pgm")),
            path("cut.pgm") + ": is an image: expected the map's YAML file, which names the image");
}

TEST_F(MapFolder, AWrittenMapReadsBack) {
  GridMap map = grid_from_text({"#.?", ".#.", "?? ", "..#"}, 0.025, {-1.0 / 3.0, 1e-7, -2.5});
  write_map(path("it's a \"map\" #1.yaml"), map);
  const GridMap back = read_map(path("it's a \"map\" #1.yaml"));
  EXPECT_EQ(back.cells, map.cells);
  EXPECT_EQ(back.width, map.width);
  EXPECT_EQ(back.height, map.height);
  EXPECT_EQ(back.resolution_m, map.resolution_m);  // shortest round trip of a double: no tolerance
  expect_near(back.T_map_grid, {-1.0 / 3.0, 1e-7, -2.5}, 0.0, 1e-15);  // the yaw is wrapped: one rounding
  EXPECT_EQ(test::content_of(path("it's a \"map\" #1.pgm")).size(),
            std::string("P5\n3 4\n255\n").size() + 12);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);  // no temporary file is left
}

TEST_F(MapFolder, AMapThatCannotBeWrittenChangesNothing) {
  const GridMap map = grid_from_text({"#"}, 0.05);
  const auto message = [&](const std::string& file, const GridMap& m) {
    return error_of([&] { write_map(file, m); }, ErrorKind::output);
  };
  EXPECT_EQ(message(path("none/map.yaml"), map),
            path("none/map.yaml") + ": cannot be written: No such file or directory");
  EXPECT_EQ(message(path("map.pgm"), map),
            path("map.pgm") + ": is the name of the image: expected one such as map.yaml");
  EXPECT_EQ(message(folder_.string() + "/", map),
            folder_.string() + "/: expected a file name such as map.yaml");
  GridMap broken = map;
  broken.width = 2;
  EXPECT_EQ(
      message(path("map.yaml"), broken),
      path("map.yaml") + ": a map of 2 x 1 with 1 cells cannot be written: expected sides from 1 to 32767");
  EXPECT_TRUE(fs::is_empty(folder_));
  fs::create_directories(path("taken.yaml"));
  EXPECT_EQ(message(path("taken.yaml"), map), path("taken.yaml") + ": cannot be written: Is a directory");
  EXPECT_FALSE(fs::exists(path("taken.pgm")));
}

// ---- the grid -----------------------------------------------------------------------------------

TEST(GridMap, APointLiesInTheCellBelowAndLeftOfIt) {
  const GridMap map = grid_from_text({"#.", "?#"}, 0.5, {-1.0, -2.0, 0.0});
  EXPECT_EQ(map.at_point(-0.9, -1.9), Cell::unknown);
  EXPECT_EQ(map.at_point(-0.5, -1.9), Cell::occupied);  // a corner belongs to the cell on its + side
  EXPECT_EQ(map.at_point(-0.9, -1.5), Cell::occupied);
  EXPECT_EQ(map.at_point(-0.1, -1.1), Cell::free);
  EXPECT_EQ(map.at_point(-1.1, -1.4), Cell::unknown);  // floor: cell -1 is not mirrored onto cell 0
  EXPECT_EQ(map.at_point(0.0, -1.4), Cell::unknown);
  const double inf = std::numeric_limits<double>::infinity();
  for (const double odd : {inf, -inf, std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300}) {
    EXPECT_EQ(map.at_point(odd, -1.9), Cell::unknown);
    EXPECT_EQ(map.at_point(-0.5, odd), Cell::unknown);
  }
}

TEST(GridMap, AYawedGridIsTurnedAboutItsCorner) {
  const GridMap map =
      grid_from_text({"?.#"}, 1.0, {10.0, 20.0, 1.5707963267948966});  // +x of the grid is +y of the map
  EXPECT_EQ(map.at_point(9.5, 20.5), Cell::unknown);
  EXPECT_EQ(map.at_point(9.5, 21.5), Cell::free);
  EXPECT_EQ(map.at_point(9.5, 22.5), Cell::occupied);
  EXPECT_EQ(map.at_point(10.5, 22.5), Cell::unknown);
}

TEST(GridMap, TextMapsAreChecked) {
  const auto message = [](const std::vector<std::string>& rows, double resolution_m) {
    return error_of([&] { grid_from_text(rows, resolution_m); });
  };
  EXPECT_EQ(message({"##", "#"}, 1.0), "text map:2: expected 2 characters as in the first row, found 1");
  EXPECT_EQ(message({"#x"}, 1.0), "text map:1: expected '#', '.', ' ' or '?', found the character 'x'");
  EXPECT_EQ(message({}, 1.0), "text map: expected 1 to 32767 rows and columns, found 0 rows of 0");
  EXPECT_EQ(message({"."}, 0.0), "text map: expected a resolution above 0 m, got 0.000000");
}

// ---- real maps ----------------------------------------------------------------------------------

TEST(RealMaps, AreReadWithTheirSize) {
  const char* set = std::getenv("PARLOC_DATA");
  const fs::path data = set != nullptr ? set : "../shared/data";
  if (!fs::exists(data / "intel" / "map.yaml"))
    GTEST_SKIP() << "no real maps in " << data << " (PARLOC_DATA)";
  const GridMap intel = read_map((data / "intel" / "map.yaml").string());
  EXPECT_EQ(intel.width, 813);
  EXPECT_EQ(intel.height, 760);
  EXPECT_EQ(intel.T_map_grid.x_m, -20.8787);
  const auto occupied = std::count(intel.cells.begin(), intel.cells.end(), Cell::occupied);
  const auto unknown = std::count(intel.cells.begin(), intel.cells.end(), Cell::unknown);
  EXPECT_GT(occupied, 0);
  EXPECT_GT(unknown, occupied);  // most of the square around the building was never seen
  const GridMap house =
      read_map((data / "tb3_house" / "map_01.yaml").string());  // has a comment in its header
  EXPECT_EQ(house.size(), 4000000u);
  EXPECT_EQ(house.resolution_m, 0.01);
}

}  // namespace
}  // namespace parloc
