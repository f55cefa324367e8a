// Things that are on no map: where they stand, what a beam sees of them, and that a seed means the same ones.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/error.h"
#include "common/simulator/clutter.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

GridMap hall() {
  std::vector<std::string> rows(200, std::string(200, '.'));
  for (std::size_t i = 0; i < 200; ++i) rows.front()[i] = rows.back()[i] = '#';
  for (auto& r : rows) r.front() = r.back() = '#';
  return grid_from_text(rows, 0.05);
}

Scenario walk() {
  Scenario s;
  s.path.points = {{2.0, 5.0, 0.0}, {8.0, 5.0, 0.0}};
  s.lidar.beams = 180;
  s.lidar.angle_min_rad = -3.1;
  s.lidar.angle_step_rad = 0.0345;
  s.lidar.sigma_range_m = 0.0;
  return s;
}

TEST(Clutter, NoneLeavesTheLogAsItWas) {
  const SimulatedLog log = simulate(walk(), hall());
  EXPECT_EQ(log.unmapped, 0u);
  EXPECT_TRUE(ClutterField(walk(), hall()).empty());
}

TEST(Clutter, BoxesStandClearOfThePathAndStayWhereTheyAre) {
  Scenario s = walk();
  s.clutter.boxes = 20;
  const ClutterField field(s, hall());
  EXPECT_GT(field.boxes(), 10u);
  std::size_t seen = 0;
  for (double x_m = 2.0; x_m <= 8.0; x_m += 0.25)
    for (double angle = -3.1; angle < 3.1; angle += 0.1) {
      const double range_m = field.range({}, 0.0, x_m, 5.0, angle, 20.0);
      EXPECT_GE(range_m, s.clutter.clearance_m - 1e-9);
      EXPECT_EQ(range_m,
                field.range({1.0, 2.0, 3.0}, 77.0, x_m, 5.0, angle, 20.0));  // neither robot nor time
      seen += range_m < 20.0 ? 1 : 0;
    }
  EXPECT_GT(seen, 100u);
}

TEST(Clutter, PeopleWalkWithTheRobot) {
  Scenario s = walk();
  s.clutter.people = 4;
  const ClutterField field(s, hall());
  for (const double time_s : {0.0, 10.0, 100.0}) {
    std::size_t seen = 0;
    double nearest_m = 100.0;
    const Pose robot{3.0 + 0.01 * time_s, 5.0, 0.3};
    for (double angle = -3.14; angle < 3.14; angle += 0.01) {
      const double range_m = field.range(robot, time_s, robot.x_m, robot.y_m, angle, 100.0);
      seen += range_m < 100.0 ? 1 : 0;
      nearest_m = std::min(nearest_m, range_m);
    }
    EXPECT_GT(seen, 20u);
    EXPECT_GE(nearest_m, s.clutter.person_min_m - s.clutter.person_radius_m);
    EXPECT_LE(nearest_m, s.clutter.person_max_m);
  }
}

TEST(Clutter, ABeamEndsAtWhateverIsNearerThanTheWall) {
  Scenario s = walk();
  s.clutter.people = 4;
  const SimulatedLog clean = simulate(walk(), hall()), log = simulate(s, hall());
  EXPECT_GT(log.unmapped, log.hits / 20);
  std::size_t shorter = 0;
  for (std::size_t k = 0; k < log.records.size(); ++k)
    for (std::size_t m = 0; m < log.records[k].scan.ranges_m.size(); ++m) {
      EXPECT_LE(log.records[k].scan.ranges_m[m], clean.records[k].scan.ranges_m[m]);
      shorter += log.records[k].scan.ranges_m[m] < clean.records[k].scan.ranges_m[m] ? 1 : 0;
    }
  EXPECT_EQ(shorter, log.unmapped);
}

TEST(Clutter, ASeedMeansTheSameThings) {
  Scenario s = walk();
  s.clutter.people = 3, s.clutter.boxes = 10;
  const std::string text = carmen_text(simulate(s, hall()));
  EXPECT_EQ(text, carmen_text(simulate(s, hall())));
  s.seed = 2;
  EXPECT_NE(text, carmen_text(simulate(s, hall())));
}

TEST(Clutter, IsReadFromAScenario) {
  const std::string text =
      "map: m.yaml\npath: p.yaml\nclutter:\n  boxes: 7\n  people: 3\n  person_max: 2.5\n";
  const Scenario s = scenario_from_text(text, "s.yaml");
  EXPECT_EQ(s.clutter.boxes, 7);
  EXPECT_EQ(s.clutter.people, 3);
  EXPECT_EQ(s.clutter.person_max_m, 2.5);
  EXPECT_THROW(scenario_from_text("map: m\npath: p\nclutter:\n  bxes: 7\n", "s.yaml"), Error);
  EXPECT_THROW(scenario_from_text("map: m\npath: p\nclutter:\n  box_min: 7\n", "s.yaml"), Error);
}

}  // namespace
}  // namespace parloc
