// Which cells a segment touches, and what lies outside of a ring of them.
#include "common/map/rasterise.h"

#include <gtest/gtest.h>

#include <random>

#include "common/map/segment_map.h"

namespace parloc {
namespace {

// ---- cells ------------------------------------------------------------------------------------------------

/// How far the closed cell is from the segment, both in cells: 0 if they touch. By the separating axes: the
/// largest gap between their shadows on the axes and on the segment's normal.
double gap(double i, double j, const GridWall& s) {
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
GridMap grid_of(std::int32_t width, std::int32_t height, std::vector<GridWall> walls) {
  GridMap map;
  map.width = width, map.height = height, map.resolution_m = 1.0;
  map.walls = std::move(walls);
  map.cells.assign(static_cast<std::size_t>(width * height), Cell::free);
  return map;
}

void expect_supercover(const GridWall& wall) {
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
      const GridWall wall = {at(x), at(y), at(x), at(y)};
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
        for (const GridWall& s : map.walls) {
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

std::vector<GridWall> ring(float x, float y, float width, float height) {
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
  std::vector<GridWall> walls = ring(3.5f, 3.5f, 12, 8);
  for (const GridWall& wall : ring(6.5f, 6.5f, 4, 3)) walls.push_back(wall);
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
  const auto no_unknown = [](std::vector<GridWall> walls) {
    GridMap map = grid_of(40, 40, std::move(walls));
    EXPECT_FALSE(rasterise_walls(map));
    EXPECT_EQ(std::count(map.cells.begin(), map.cells.end(), Cell::unknown), 0);
    EXPECT_GT(std::count(map.cells.begin(), map.cells.end(), Cell::occupied), 0);
  };
  std::vector<GridWall> court = ring(4.5f, 4.5f, 30, 30);
  court.pop_back();
  no_unknown(court);
  std::vector<GridWall> court_with_pillar = court;
  for (const GridWall& wall : ring(15.5f, 15.5f, 4, 4)) court_with_pillar.push_back(wall);
  no_unknown(court_with_pillar);
  // A court with a door whose walls have a thickness: only the inside of the walls is enclosed.
  std::vector<GridWall> thick = ring(4.5f, 4.5f, 30, 2);
  for (const GridWall& wall : ring(4.5f, 4.5f, 2, 30)) thick.push_back(wall);
  for (const GridWall& wall : ring(32.5f, 4.5f, 2, 30)) thick.push_back(wall);
  no_unknown(thick);
}

}  // namespace
}  // namespace parloc
