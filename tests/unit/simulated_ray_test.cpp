// The simulator's ray caster against SPEC 2.2.
#include <gtest/gtest.h>

#include "tests/unit/map_t1.h"
#include "tests/unit/simulated.h"

namespace parloc {
namespace {

TEST(SimulatedRay, meets_the_table_of_the_specification) {
  struct Row {
    double x_m, angle_deg, range_m;
    int i, j;
  };
  const Row rows[] = {{0.8, 0, 1.2, 6, 4},
                      {0.8, 30, 2.7, 8, 7},
                      {0.8, 45, 1.909188309204, 6, 7},
                      {0.8, 90, 1.35, 3, 7},
                      {0.8, 135, 1.838477631085, 0, 6},
                      {0.8, 180, 1.3, 0, 4},
                      {0.8, 200, 1.383431104219, 0, 3},
                      {0.8, 270, 0.65, 3, 2},
                      {0.8, 300, 1.905255888326, 5, 0},
                      {0.8, 333, 3.030280841613, 9, 1},
                      {0.5, 180, 1.0, 0, 4},
                      {0.5, 0, 1.5, 6, 4}};
  const GridMap map = test::map_t1();
  for (const Row& row : rows) {
    const SimulatedHit hit = cast_simulated_ray(map, row.x_m, 0.15, row.angle_deg * kDeg, 10.0);
    EXPECT_TRUE(hit.hit) << row.angle_deg;
    EXPECT_NEAR(hit.range_m, row.range_m, 1e-12) << row.angle_deg;  // the table has 12 decimals
    EXPECT_EQ(hit.i, row.i) << row.angle_deg;
    EXPECT_EQ(hit.j, row.j) << row.angle_deg;
  }
}

TEST(SimulatedRay, misses_beyond_its_reach_and_outside_the_grid) {
  const GridMap map = test::map_t1();
  const SimulatedHit near = cast_simulated_ray(map, 0.8, 0.15, 0.0, 1.19);
  EXPECT_FALSE(near.hit);
  EXPECT_EQ(near.range_m, 1.19);
  const SimulatedHit inside = cast_simulated_ray(map, 2.2, 0.2, 1.0, 10.0);  // starts in cell (6, 4)
  EXPECT_TRUE(inside.hit);
  EXPECT_EQ(inside.range_m, 0.0);
  EXPECT_FALSE(cast_simulated_ray(map, -1.5, 0.15, 0.0, 10.0).hit);
  EXPECT_FALSE(cast_simulated_ray(map, std::nan(""), 0.15, 0.0, 10.0).hit);
  const GridMap open = grid_from_text({"..", "??"}, 0.5);
  EXPECT_FALSE(cast_simulated_ray(open, 0.2, 0.7, -1.2, 10.0).hit);  // unknown cells stop nothing
}

TEST(SimulatedRay, knows_a_turned_grid) {
  const GridMap straight = test::map_t1();
  GridMap turned = straight;
  turned.T_map_grid = {3.0, -2.0, 0.7};
  for (int k = 0; k < 36; ++k) {
    const Pose in_grid = relative({0.8, 0.15, 0.3 + k * 10.0 * kDeg}, straight.T_map_grid);
    const Pose in_map = compose(turned.T_map_grid, in_grid);
    EXPECT_NEAR(cast_simulated_ray(turned, in_map.x_m, in_map.y_m, in_map.theta_rad, 10.0).range_m,
                cast_simulated_ray(straight, 0.8, 0.15, 0.3 + k * 10.0 * kDeg, 10.0).range_m, 1e-12);
  }
}

}  // namespace
}  // namespace parloc
