// Random drives: they go where a robot can go, clear of walls, and a seed means one drive.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/error.h"
#include "common/map/map_reader.h"
#include "common/simulator/drive.h"
#include "common/simulator/simulator.h"
#include "common/simulator/wander.h"

namespace parloc {
namespace {

constexpr double kClearance_m = 0.3;

GridMap office() {
  return read_map("maps/office.yaml");
}

double nearest_wall_m(const GridMap& map, const Pose& p) {
  double least_m = 1.0;
  for (int k = 0; k < 72; ++k)
    least_m = std::fmin(least_m, cast_simulated_ray(map, p.x_m, p.y_m, 0.0873 * k, 1.0).range_m);
  return least_m;
}

TEST(Wander, StaysClearOfWalls) {
  const GridMap map = office();
  const WanderArea area(map, kClearance_m);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const WaypointPath path = area.wander(60.0, 0.5, 0.8, seed);
    const Drive drive = plan_drive(path);
    EXPECT_GE(drive.duration_s(), 60.0);
    // The path between two nodes is looked at by cell: up to a cell may be lost.
    for (double t = 0; t < drive.duration_s(); t += 0.5)
      EXPECT_GE(nearest_wall_m(map, pose_at(drive, t)), kClearance_m - map.resolution_m) << "seed " << seed;
  }
}

TEST(Wander, ASeedIsADriveAndSeedsDiffer) {
  const WanderArea area(office(), kClearance_m);
  const WaypointPath a = area.wander(30.0, 0.5, 0.8, 7), b = area.wander(30.0, 0.5, 0.8, 7);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t k = 0; k < a.points.size(); ++k) {
    EXPECT_EQ(a.points[k].x_m, b.points[k].x_m);
    EXPECT_EQ(a.points[k].y_m, b.points[k].y_m);
  }
  std::set<double> starts;
  for (std::uint64_t seed = 0; seed < 50; ++seed)
    starts.insert(area.wander(1.0, 0.5, 0.8, seed).points.front().x_m);
  EXPECT_GT(starts.size(), 30u);  // of about 250 columns
}

TEST(Wander, KeepsToTheLargestRegion) {
  const GridMap map =
      grid_from_text({"##########", "#....#..##", "#....#..##", "#....#####", "##########"}, 0.5);
  const WanderArea area(map, 0.2);
  EXPECT_NEAR(area.area_m2(), 12 * 0.25, 1e-9);
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (const Waypoint& p : area.wander(10.0, 0.5, 0.8, seed).points) EXPECT_LT(p.x_m, 2.5);
}

TEST(Wander, NeedsRoom) {
  const GridMap map = grid_from_text({"####", "#..#", "####"}, 0.05);
  EXPECT_THROW(WanderArea(map, 0.3), Error);
}

}  // namespace
}  // namespace parloc
