// A world that is no longer as its map has it: how much of it differs, where, and that a seed means one
// change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/eval/families/places.h"
#include "common/map/map_reader.h"
#include "common/simulator/changed_world.h"
#include "common/simulator/simulator.h"
#include "common/simulator/wander.h"

namespace parloc {
namespace {

double occupied(const GridMap& map) {
  return static_cast<double>(std::count(map.cells.begin(), map.cells.end(), Cell::occupied));
}

class ChangedWorld : public testing::Test {
 protected:
  GridMap map_ = read_map("maps/office.yaml");
  WaypointPath path_ = WanderArea(map_, 0.3).wander(60.0, 0.5, 0.8, 3);
};

TEST_F(ChangedWorld, FurnitureIsMovedByTheShareThatWasDrawn) {
  for (const double share : {0.05, 0.2}) {
    const WorldChange change = move_furniture(map_, path_, 0.35, share, 7);
    const double of = occupied(map_);
    // A piece is at most 1.5 x 1.5 m = 900 cells, by which each of the two may be more.
    EXPECT_NEAR(static_cast<double>(change.removed.size()) / of, 0.5 * share, 900.0 / of);
    EXPECT_NEAR(static_cast<double>(change.added.size()) / of, 0.5 * share, 900.0 / of);
    const GridMap world = changed_world(map_, map_, change);
    double differ = 0.0;
    for (std::size_t k = 0; k < map_.size(); ++k) differ += world.cells[k] != map_.cells[k] ? 1.0 : 0.0;
    EXPECT_EQ(differ, static_cast<double>(change.removed.size() + change.added.size()));
    for (const std::size_t cell : change.removed) EXPECT_EQ(map_.cells[cell], Cell::occupied);
    for (const std::size_t cell : change.added) EXPECT_EQ(map_.cells[cell], Cell::free);
  }
}

TEST_F(ChangedWorld, NothingIsPutInTheWay) {
  const std::vector<std::uint8_t> near = cells_near_path(map_, path_, 0.35);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const WorldChange& change :
         {move_furniture(map_, path_, 0.35, 0.2, seed), change_doors(map_, path_, 0.35, 0.6, seed)})
      for (const std::size_t cell : change.added) EXPECT_EQ(near[cell], 0);
  }
  EXPECT_GT(std::count(near.begin(), near.end(), 1), 1000);
}

TEST_F(ChangedWorld, ASeedIsAChange) {
  const WorldChange a = move_furniture(map_, path_, 0.35, 0.1, 7),
                    b = move_furniture(map_, path_, 0.35, 0.1, 7);
  EXPECT_EQ(a.removed, b.removed);
  EXPECT_EQ(a.added, b.added);
  EXPECT_NE(a.added, move_furniture(map_, path_, 0.35, 0.1, 8).added);
}

// The finer world must have lost what the map lost, slivers beyond the map's cells included.
TEST_F(ChangedWorld, AFinerWorldChangesWithTheMap) {
  const GridMap fine = read_map("maps/fine/office.yaml");
  const WorldChange change = move_furniture(map_, path_, 0.35, 0.2, 7);
  const GridMap world = changed_world(fine, map_, change), coarse = changed_world(map_, map_, change);
  double agree = 0.0, all = 0.0;
  for (const std::vector<std::size_t>* cells : {&change.removed, &change.added})
    for (const std::size_t cell : *cells) {
      const Pose centre = compose(
          map_.T_map_grid,
          {(static_cast<double>(cell % static_cast<std::size_t>(map_.width)) + 0.5) * map_.resolution_m,
           (static_cast<double>(cell / static_cast<std::size_t>(map_.width)) + 0.5) * map_.resolution_m,
           0.0});
      all += 1.0;
      agree += world.at_point(centre.x_m, centre.y_m) == coarse.cells[cell] ? 1.0 : 0.0;
    }
  EXPECT_GT(all, 1000.0);
  EXPECT_EQ(agree, all);
  // Through what was taken away beams pass.
  double fewer = 0.0;
  for (std::size_t k = 0; k < fine.size(); ++k)
    fewer += fine.cells[k] == Cell::occupied && world.cells[k] != Cell::occupied ? 1.0 : 0.0;
  EXPECT_GT(fewer, 0.9 * 25.0 * static_cast<double>(change.removed.size()));
}

TEST_F(ChangedWorld, OpeningsAreFoundClosedAndBroken) {
  const std::vector<Opening> openings = find_openings(map_);
  EXPECT_GE(openings.size(), 20u);  // 26 rooms
  EXPECT_LE(openings.size(), 120u);
  const WorldChange change = change_doors(map_, path_, 0.35, 0.5, 7);
  const GridMap world = changed_world(map_, map_, change);
  const std::size_t left = find_openings(world).size();
  EXPECT_FALSE(change.added.empty());
  EXPECT_FALSE(change.removed.empty());
  EXPECT_NE(left, openings.size());
  std::size_t closed = 0;
  for (const Opening& opening : openings)
    closed += std::all_of(opening.cells.begin(), opening.cells.end(),
                          [&](std::size_t cell) { return world.cells[cell] == Cell::occupied; })
                  ? 1
                  : 0;
  EXPECT_GE(static_cast<double>(closed), 0.3 * static_cast<double>(openings.size()));
  EXPECT_LE(static_cast<double>(closed), 0.6 * static_cast<double>(openings.size()));
}

TEST(Openings, OneDoorInAWall) {
  std::vector<std::string> rows(40, std::string(60, '.'));
  for (int i = 0; i < 60; ++i) rows.front()[i] = rows.back()[i] = '#', rows[20][i] = rows[21][i] = '#';
  for (auto& row : rows) row.front() = row.back() = '#';
  for (int i = 30; i < 39; ++i) rows[20][i] = rows[21][i] = '.';  // 0.9 m
  const std::vector<Opening> openings = find_openings(grid_from_text(rows, 0.1));
  ASSERT_EQ(openings.size(), 1u);
  EXPECT_EQ(openings[0].cells.size(), 18u);
}

TEST(ScaledAboutGrid, KeepsTheCornerAndGoesBack) {
  const Pose corner{-3.0, 2.0, 0.4}, pose{5.0, 6.0, 1.0};
  const Pose there = scaled_about_grid(pose, corner, 1.01);
  EXPECT_NEAR(distance_m(there, corner) / distance_m(pose, corner), 1.01, 1e-12);
  EXPECT_NEAR(distance_m(scaled_about_grid(there, corner, 1.0 / 1.01), pose), 0.0, 1e-12);
  EXPECT_NEAR(there.theta_rad, pose.theta_rad, 1e-12);
}

TEST(CorridorPlace, IsAsLongAndWideAsItSays) {
  const Place place = corridor_place(70.0, 2.37);
  for (const auto& map : {place.map, place.world}) {
    const double half_cell_m = 0.5 * map->resolution_m + 1e-9;
    EXPECT_NEAR(cast_simulated_ray(*map, 30.0, 1.0, 0.5 * M_PI, 10.0).range_m, 1.37, half_cell_m);
    EXPECT_NEAR(cast_simulated_ray(*map, 30.0, 1.0, -0.5 * M_PI, 10.0).range_m, 1.0, half_cell_m);
    EXPECT_NEAR(cast_simulated_ray(*map, 30.0, 1.0, 0.0, 100.0).range_m, 40.0, half_cell_m);
  }
}

}  // namespace
}  // namespace parloc
