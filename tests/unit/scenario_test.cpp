// Scenario files: what is read, and what is refused in which words.
#include "common/simulator/scenario.h"

#include <cstdlib>

#include "tests/unit/simulated.h"

namespace parloc {
namespace {

TEST(ScenarioReader, names_what_is_wrong_and_where) {
  const std::string begin = "map: a.yaml\npath: b.yaml\n";
  const std::string lidar = begin + "lidar:\n  ", odometry = begin + "odometry:\n  ";
  const struct {
    std::string text;
    const char* expected;
  } cases[] = {
      {begin + "sed: 3\n", "s.yaml:3: unknown key 'sed'; the nearest valid key is 'seed'"},
      {lidar + "beems: 3\n", "s.yaml:4: unknown key 'lidar.beems'; the nearest valid key is 'lidar.beams'"},
      {"path: b.yaml\n", "s.yaml:1: map is missing"},
      {begin + "map: c.yaml\n", "s.yaml:3: duplicate key 'map'"},
      {lidar + "beams: 0\n", "s.yaml:4: lidar.beams must be 1 to 4096, got 0"},
      {lidar + "beams: 3.5\n", "s.yaml:4: lidar.beams: expected a whole number, got '3.5'"},
      {begin + "lidar: 3\n", "s.yaml:3: lidar: expected lines of 'key: value', got '3'"},
      {lidar + "range_max: .nan\n", "s.yaml:4: lidar.range_max: expected a number"},
      {lidar + "range_min: 9\n", "s.yaml:4: lidar.range_min must be below range_max"},
      {lidar + "over_range: far\n", "s.yaml:4: lidar.over_range: expected max, inf or code, got 'far'"},
      {lidar + "mount: [1, 2]\n",
       "s.yaml:4: lidar.mount: expected [x, y, heading in degrees], got a list of 2"},
      {lidar + "upside_down: 1\n", "s.yaml:4: lidar.upside_down: expected true or false, got '1'"},
      {lidar + "scan_time: 2\n", "s.yaml:4: lidar.scan_time must be 0 to 1, got 2"},
      {lidar + "stamp_at: end\n", "s.yaml:4: lidar.stamp_at: expected first, middle or last, got 'end'"},
      {begin + "lidars:\n  - beams: 3\n  - beems: 3\n",
       "s.yaml:5: unknown key 'lidars[1].beems'; the nearest valid key is 'lidars[1].beams'"},
      {odometry + "kappa: 1e-4\n", "s.yaml:4: odometry.kappa needs form: wheels beside it"},
      {odometry + "form: wheels\n  alpha1: 0.1\n",
       "s.yaml:5: odometry.alpha1 has no meaning for form: wheels"},
      {odometry + "form: wheels\n  kappa: -1\n", "s.yaml:5: odometry.kappa must be 0 to 1, got -1"},
      {"map: $PARLOC_NO_SUCH/a.yaml\npath: b.yaml\n",
       "s.yaml: $PARLOC_NO_SUCH/a.yaml: expected the environment variable PARLOC_NO_SUCH to name a folder"},
      {begin + "lidars: 3\n", "s.yaml:3: lidars: expected a list of groups, got '3'"},
      {begin + "lidars: []\n", "s.yaml:3: lidars must be a list of 1 to 9 LiDARs"},
      {begin + "lidars:\n  - 3\n", "s.yaml:4: lidars[0]: expected lines of 'key: value', got '3'"},
      {begin + "lidar: {beams: 3}\nlidars: [{beams: 3}]\n",
       "s.yaml:4: lidars and lidar: only one of the two may be there"},
      {odometry + "alpha1: 0.1\n", "s.yaml:4: odometry.alpha1 needs form beside it"},
      {begin + "seed: -1\n", "s.yaml:3: seed must be 0 to 18446744073709551615, got -1"},
      {"map: [a\n", "not valid YAML"},
      {"", "s.yaml: map is missing"},
      {"map: a\n---\nmap: b\n", "expected one document, found a second one"},
      {", 0], a[1,b\n", "expected one document, found a second one"},  // yaml-cpp alone never ends here
      {"map: &a [*a]\n", "s.yaml:1: anchors ('&name') are not allowed"},
      {"[[[[[[[[[]]]]]]]]]\n", "s.yaml:1: nested too deeply"},
  };
  for (const auto& c : cases)
    expect_parts(error_of([&] { scenario_from_text(c.text, "s.yaml"); }, ErrorKind::config), {c.expected});
}

TEST(ScenarioReader, checks_the_points_of_a_path) {
  const std::string begin = "points:\n  - [0, 0]\n  - ", end = "points: [[0, 0], [1, 0]]\n";
  const struct {
    std::string text;
    const char* expected;
  } cases[] = {
      {"points: [[0, 0]]\n", "p.yaml:1: points: expected a list of at least two points, got a list of 1"},
      {begin + "[0, x]\n", "p.yaml:3: points: point 2, y: expected a number, got 'x'"},
      {begin + "[1]\n",
       "p.yaml:3: points: point 2 must be [x, y], [x, y, pause_s] or [x, y, pause_s, spin_deg]"},
      {begin + "[0, 0]\n", "p.yaml:3: points: point 2 is the same as the one before"},
      {begin + "[1, 0, -1]\n", "p.yaml:3: points: point 2, pause_s must be 0 to 3600, got -1"},
      {begin + "[1, 0, 0, 40000]\n",
       "p.yaml:3: points: point 2, spin_deg must be -36000 to 36000, got 40000"},
      {begin + "[1e9, 0]\n", "p.yaml:3: points: point 2, x must be -100000 to 100000, got 1e9"},
      {"speed: 0\n" + end, "p.yaml:1: speed must be 0.001 to 100, got 0"},
      {"sped: 1\n" + end, "p.yaml:1: unknown key 'sped'; the nearest valid key is 'speed'"},
  };
  for (const auto& c : cases)
    expect_parts(error_of([&] { waypoints_from_text(c.text, "p.yaml"); }, ErrorKind::config), {c.expected});
}

TEST(ScenarioReader, reads_what_is_written) {
  const Scenario s = scenario_from_text(
      "map: ../m.yaml\nlocalization_map: n.yaml\npath: /p.yaml\nseed: 18446744073709551615\nscan_rate: 5\n"
      "lidar:\n  beams: 7\n  angle_min_deg: -90\n  angle_step_deg: 30\n  over_range: code\n"
      "  over_range_code: 50\n  dropout_value: nan\n  mount: [0.1, 0.2, 180]\n"
      "odometry:\n  form: thrun\n  alpha1: 0.3\n  rate: 10\n  drift_deg_per_m: 1\n",
      "/a/b/s.yaml");
  EXPECT_EQ(s.map_path, "/a/m.yaml");
  EXPECT_EQ(s.localization_map_path, "/a/b/n.yaml");
  EXPECT_EQ(s.path_file, "/p.yaml");
  EXPECT_EQ(s.seed, 18446744073709551615u);
  EXPECT_EQ(s.lidar.beams, 7);
  EXPECT_DOUBLE_EQ(s.lidar.angle_min_rad, -90.0 * kDeg);
  EXPECT_DOUBLE_EQ(s.lidar.angle_step_rad, 30.0 * kDeg);
  EXPECT_EQ(s.lidar.over_range, OverRange::code);
  EXPECT_EQ(s.lidar.over_range_code_m, 50.0);
  EXPECT_EQ(s.lidar.dropout_value, DropoutValue::nan);
  EXPECT_DOUBLE_EQ(s.lidar.T_base_sensor.theta_rad, -std::numbers::pi);
  EXPECT_EQ(s.odometry.noise.form, MotionForm::thrun);
  EXPECT_EQ(s.odometry.noise.alpha1, 0.3);
  EXPECT_DOUBLE_EQ(s.odometry.drift_rad_per_m, kDeg);
}

TEST(ScenarioReader, reads_several_lidars) {
  const Scenario s = scenario_from_text(
      "map: m.yaml\npath: p.yaml\nlidars:\n  - {beams: 7, scan_time: 0.05, stamp_at: middle}\n"
      "  - beams: 9\n    upside_down: true\n    delay: 0.1\n    mount: [-0.1, 0.2, 90]\n  - {}\n",
      "s.yaml");
  EXPECT_EQ(s.lidar.beams, 7);
  EXPECT_EQ(s.lidar.scan_time_s, 0.05);
  EXPECT_EQ(s.lidar.stamp_at, StampAt::middle);
  ASSERT_EQ(s.more_lidars.size(), 2u);
  EXPECT_EQ(s.more_lidars[0].beams, 9);
  EXPECT_TRUE(s.more_lidars[0].upside_down);
  EXPECT_EQ(s.more_lidars[0].delay_s, 0.1);
  EXPECT_DOUBLE_EQ(s.more_lidars[0].T_base_sensor.theta_rad, 90.0 * kDeg);
  EXPECT_EQ(s.more_lidars[1].beams, SimulatedLidar{}.beams);
  const WaypointPath path = waypoints_from_text("points:\n  - [0, 0, 1, -720]\n  - [1, 0]\n", "p.yaml");
  EXPECT_DOUBLE_EQ(path.points[0].spin_rad, -720.0 * kDeg);
  EXPECT_EQ(path.points[1].spin_rad, 0.0);
}

TEST(ScenarioReader, reads_wheels_and_folders_of_the_environment) {
  setenv("PARLOC_SCENARIO_TEST", "/somewhere", 1);
  const Scenario s = scenario_from_text(
      "map: $PARLOC_SCENARIO_TEST/a.yaml\nlocalization_map: here.yaml\npath: b.yaml\n"
      "odometry: {form: wheels, kappa: 5e-3, wheel_base: 0.2}\n",
      "folder/s.yaml");
  EXPECT_EQ(s.map_path, "/somewhere/a.yaml");
  EXPECT_EQ(s.localization_map_path, "folder/here.yaml");
  EXPECT_EQ(s.odometry.errors, OdometryErrors::wheels);
  EXPECT_EQ(s.odometry.kappa_m, 5e-3);
  EXPECT_EQ(s.odometry.wheel_base_m, 0.2);
  const Scenario as_before = scenario_from_text("map: a\npath: b\nodometry: {form: thrun}\n", "s.yaml");
  EXPECT_EQ(as_before.odometry.errors, OdometryErrors::motion_model);
  EXPECT_EQ(as_before.odometry.noise.form, MotionForm::thrun);
}

}  // namespace
}  // namespace parloc
