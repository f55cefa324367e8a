// What `map check` finds: each oddity in a map made for it, and nothing in sound ones.
#include "common/map/check/map_findings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "common/map/check/known_part.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

namespace fs = std::filesystem;
using Findings = std::vector<std::string>;

/// Two rooms of 12 x 6 m side by side, with a door, in cells of 0.1 m; outside is unknown.
GridMap rooms() {
  GridMap map;
  map.width = 140, map.height = 100;
  map.resolution_m = 0.1;
  map.name = "rooms";
  map.cells.assign(14000, Cell::unknown);
  for (std::int32_t j = 20; j <= 80; ++j) {
    for (std::int32_t i = 10; i <= 130; ++i) {
      const bool is_wall = i == 10 || i == 130 || j == 20 || j == 80 || (i == 70 && (j < 45 || j > 54));
      map.cells[map.index(i, j)] = is_wall ? Cell::occupied : Cell::free;
    }
  }
  return map;
}

/// The findings of an image map whose cells are those of rooms(), in the greys given.
class Images : public ::testing::Test {
 protected:
  Images() : folder_(fs::temp_directory_path() / ("parloc_findings_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~Images() override { fs::remove_all(folder_); }

  template <class GreyOf>
  Findings findings(const std::string& yaml, const GreyOf& grey_of) const {
    const GridMap map = rooms();
    std::ofstream image(folder_ / "map.pgm", std::ios::binary);
    image << "P5\n140 100\n255\n";
    for (std::int32_t j = map.height - 1; j >= 0; --j)
      for (std::int32_t i = 0; i < map.width; ++i) image << static_cast<char>(grey_of(map.at(i, j), i, j));
    image.close();
    return image_findings(read_image_map("image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n" + yaml,
                                         (folder_ / "map.yaml").string()));
  }
  Findings findings(const std::string& yaml, int free = 254, int occupied = 0, int unknown = 205) const {
    return findings(yaml, [&](Cell cell, std::int32_t, std::int32_t) {
      return cell == Cell::free ? free : cell == Cell::occupied ? occupied : unknown;
    });
  }

  fs::path folder_;
};

void expect_first(const Findings& findings, const std::string& start) {
  ASSERT_FALSE(findings.empty()) << start;
  EXPECT_EQ(findings[0].rfind(start, 0), 0u) << findings[0];
}
void expect_one(const Findings& findings, const std::string& start) {
  expect_first(findings, start);
  EXPECT_EQ(findings.size(), 1u);
}

const std::string kUsual = "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

TEST_F(Images, SoundOnesHaveNoFindings) {
  EXPECT_EQ(findings(kUsual), Findings{});
  EXPECT_EQ(findings(kUsual, 255, 0, 128), Findings{});
  EXPECT_EQ(findings(kUsual, 254, 0, 254), Findings{});  // nothing was meant to be unknown
  EXPECT_EQ(findings("negate: 1\noccupied_thresh: 0.65\nfree_thresh: 0.196\n", 0, 255, 100), Findings{});
  EXPECT_EQ(findings("negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\nmode: raw\n", 0, 100, 255),
            Findings{});
}

TEST_F(Images, AGreyThatWasMeantToBeUnknown) {
  expect_one(findings("negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"),
             "nothing is unknown: grey 205, 47.3 % of the image, is free: its occupancy 0.19608 is below "
             "free_thresh 0.25; 0.196 would leave it unknown");
  expect_first(
      findings("negate: 0\noccupied_thresh: 0.4\nfree_thresh: 0.2\n", 254, 0, 128),
      "nothing is unknown: grey 128, 47.3 % of the image, is occupied: its occupancy 0.49804 is above "
      "occupied_thresh 0.4");
}

TEST_F(Images, AModeForAnotherKindOfImage) {
  expect_one(
      findings(kUsual + "mode: scale\n", 254, 0, 180),
      "mode scale, but an image of black, white and one grey without transparency is trinary: grey 180, "
      "47.3 % of the image, is unknown here and occupancy 22 in nav2");
  expect_first(findings(kUsual + "mode: raw\n"), "mode raw, but 97.1 % of the image are 101 to 254");
  expect_first(findings(kUsual, 0, 100, 255), "mode trinary, but all values are 0 to 100 or 255");
  expect_one(findings(kUsual,
                      [](Cell cell, std::int32_t i, std::int32_t j) {
                        return cell == Cell::occupied ? 0 : cell == Cell::free ? 254 : 50 + (i + j) % 150;
                      }),
             "mode trinary, but 47.3 % of the image are");
}

TEST_F(Images, MostlyWalls) {
  expect_one(findings("negate: 1\noccupied_thresh: 0.85\nfree_thresh: 0.196\n"),
             "mostly walls: 94.5 % of the known cells are occupied; with negate: 0 it would be 5.5 %");
}

// ---- cells --------------------------------------------------------------------------------------

TEST(GridFindings, ASoundMapHasNone) {
  EXPECT_EQ(grid_findings(rooms()), Findings{});
}

TEST(GridFindings, ThinWallsWithGaps) {
  GridMap map = rooms();
  std::size_t gaps = 0;
  for (std::int32_t i = 14; i < 66; i += 7, ++gaps) map.cells[map.index(i, 20)] = Cell::free;
  for (std::int32_t j = 24; j < 76; j += 9, ++gaps)
    map.cells[map.index(130, j)] = map.cells[map.index(130, j + 1)] = Cell::free;
  expect_one(grid_findings(map),
             "walls one cell thin have " + std::to_string(gaps) + " gaps of 1 to 3 cells, one in every ");
  // The same in a wall that has another cell behind: no ray passes.
  for (std::int32_t i = 10; i <= 130; ++i) map.cells[map.index(i, 19)] = Cell::occupied;
  for (std::int32_t j = 20; j <= 80; ++j) map.cells[map.index(131, j)] = Cell::occupied;
  EXPECT_EQ(grid_findings(map), Findings{});
}

TEST(GridFindings, AnUnlikelyResolution) {
  GridMap map = rooms();
  map.resolution_m = 1.0;
  expect_one(grid_findings(map),
             "a resolution of 1 m is unlikely: it makes the typical place 59 m wide and walls 1 m thick");
  map.resolution_m = 0.005;
  expect_one(grid_findings(map),
             "a resolution of 0.005 m is unlikely: it makes the typical place 0.295 m wide");
}

TEST(GridFindings, ABorderOfUnknown) {
  GridMap map = rooms();
  EXPECT_EQ(known_part(map).i, 10);
  EXPECT_EQ(known_part(map).j, 20);
  EXPECT_EQ(known_part(map).size(), 121u * 61u);
  GridMap wide = map;
  wide.width = 1000, wide.height = 1000;
  wide.cells.assign(1'000'000, Cell::unknown);
  for (std::int32_t j = 0; j < map.height; ++j)
    for (std::int32_t i = 0; i < map.width; ++i) wide.cells[wide.index(i + 500, j + 300)] = map.at(i, j);
  expect_one(grid_findings(wide), "a border of unknown is 99 % of the cells and takes about 38 MB of memory");
  EXPECT_EQ(cropped(wide, 0).size(), 121u * 61u);
  EXPECT_EQ(cropped(cropped(wide, 3), 5).size(), 127u * 67u);  // no farther than the map
  wide.cells.assign(1'000'000, Cell::unknown);
  EXPECT_EQ(error_of([&] { cropped(wide, 0); }), "rooms: expected a known cell to crop to, found none");
}

// The maps that come with the project are sound.
TEST(GridFindings, TheProjectsMapsHaveNone) {
  std::size_t maps = 0;
  for (const auto& entry : fs::directory_iterator(std::string(PARLOC_SOURCE_DIR) + "/maps")) {
    if (entry.path().extension() != ".yaml") continue;
    const GridMap map = read_map(entry.path().string());
    if (!map.walls.empty()) continue;
    EXPECT_EQ(grid_findings(map), Findings{}) << entry.path();
    ++maps;
  }
  EXPECT_GE(maps, 6u);
}

}  // namespace
}  // namespace parloc
