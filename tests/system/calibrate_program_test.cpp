// `parloc learn --what` as a person or a script meets it: a mount, scales and a delay that were put into
// simulated drives are found, what a drive leaves open is said, and what is wrong on the command line.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

class CalibrateProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() { open("parloc_calibrate_test"); }

  /// A drive through a map of maps/fine; returns its log.
  static std::string drive(const std::string& name, const std::string& map, const std::string& points,
                           const std::string& lidar, const std::string& odometry) {
    const std::string maps = std::string(PARLOC_SOURCE_DIR) + "/maps/";
    write(name + "_path.yaml", "speed: 0.5\nturn_rate: 0.6\npoints:\n" + points);
    write(name + ".yaml", "map: " + maps + "fine/" + map + ".yaml\npath: " + path(name + "_path.yaml") +
                              "\nscan_rate: 5\nseed: 3\nlidar:\n  beams: 360\n  angle_min_deg: -180\n"
                              "  angle_step_deg: 1\n  range_max: 8\n  sigma_range: 0.02\n" +
                              lidar +
                              "odometry:\n  rate: 20\n  form: seed\n  alpha1: 0.02\n  alpha2: 0.02\n"
                              "  alpha3: 0.02\n  alpha4: 0.01\n" +
                              odometry);
    done({"simulate", "--scenario", path(name + ".yaml"), "--out", path(name), "--quiet"});
    return path(name + "/scans.log");
  }
  static Args learn(const std::string& log, const std::string& what = "mount,odometry,delay") {
    return {"learn", "--log", log, "--what", what, "--out", path("learned")};
  }
  static constexpr const char* kTurning =
      "  - [1.8, 1.7, 0, 400]\n  - [6.4, 1.7, 0, -400]\n  - [8.44, 4.42]\n  - [12.04, 4.42, 1, 400]\n"
      "  - [8.44, 4.42]\n  - [6.4, 1.7]\n  - [1.8, 1.7]\n";
};

TEST_F(CalibrateProgram, FindsWhatWasPutIntoADrive) {
  const std::string log =
      drive("beside", "hall_obstacles", kTurning, "  mount: [0.1, -0.3, 90]\n  upside_down: true\n",
            "  scale_translation: 0.95\n  scale_rotation: 1.1\n  delay: 0.15\n");
  write("wrong.yaml", "lidars:\n  robotlaser1: {x: 0, y: 0, yaw: 0, upside_down: false}\n");
  const Outcome found = done(with(learn(log), {"--config", path("wrong.yaml"), "--json"}));
  const Json j = Json::parse(found.out);
  const Json& lidar = j["lidars"][0];
  EXPECT_NEAR(lidar["x"]["value"], 0.1, 0.01);
  EXPECT_NEAR(lidar["y"]["value"], -0.3, 0.01);
  EXPECT_NEAR(lidar["yaw"]["value"], 1.5708, 0.0087);
  EXPECT_EQ(lidar["upside_down"]["value"], true);
  EXPECT_EQ(lidar["upside_down"]["stated"], false);
  EXPECT_NEAR(j["odometry"]["odometry_scale_drive"]["value"], 1.0 / 0.95, 0.005);
  EXPECT_NEAR(j["odometry"]["odometry_scale_turn"]["value"], 1.0 / 1.1, 0.005);
  EXPECT_NEAR(j["odometry"]["odometry_delay_s"]["value"], 0.15, 0.01);
  EXPECT_EQ(j["not_determined"].size(), 0u);
  expect_parts(found.err, {"upside down", "scale of drive", "difference"});

  // What it prints is a configuration, and with it nothing is left to be found.
  const Outcome settings = done(with(learn(log), {"--quiet", "--config", path("wrong.yaml")}));
  EXPECT_EQ(settings.err, "");
  EXPECT_EQ(settings.out, read("learned/calibration.yaml"));
  write("found.yaml", settings.out);
  const Json again = Json::parse(done(with(learn(log), {"--json", "--config", path("found.yaml")})).out);
  EXPECT_EQ(again["lidars"][0]["upside_down"]["stated"], true);
  EXPECT_NEAR(again["lidars"][0]["x"]["stated"], 0.1, 0.01);
}

TEST_F(CalibrateProgram, SaysWhatADriveLeavesOpen) {
  const std::string straight = drive("straight", "office", "  - [1.45, 8.5]\n  - [9.65, 8.5]\n", "", "");
  const Json j = Json::parse(done(with(learn(straight), {"--json"})).out);
  EXPECT_EQ(j["lidars"][0]["yaw"]["determined"], true);
  EXPECT_EQ(j["lidars"][0]["x"]["determined"], false);
  EXPECT_TRUE(j["lidars"][0]["x"]["value"].is_null());
  EXPECT_EQ(j["odometry"]["odometry_scale_turn"]["determined"], false);
  const Outcome text = done(with(learn(straight), {"--quiet"}));
  expect_parts(text.out, {"# not determined by this drive: robotlaser1 x", "scale of turn", "    yaw: "});
  EXPECT_EQ(text.out.find("    x: "), std::string::npos);

  std::string still;  // one scan, again and again
  const std::string moving = read("straight/scans.log");
  const std::size_t line = moving.find("ROBOTLASER1 ", moving.find('\n'));
  const std::string scan = moving.substr(line, moving.find('\n', line) - line);
  for (int k = 0; k < 50; ++k) {
    std::string now = scan;
    const std::size_t stamp = now.rfind(' ', now.rfind(' ', now.rfind(' ') - 1) - 1);
    still += now.substr(0, stamp) + " " + std::to_string(1.0 + 0.2 * k) + " parloc 0\n";
  }
  write("still.log", still);
  const Json none = Json::parse(done(with(learn(path("still.log")), {"--json"})).out);
  EXPECT_EQ(none["not_determined"].size(), 8u);
}

TEST_F(CalibrateProgram, OneLineForWhatIsWrong) {
  write("empty.log", "# nothing\n");
  expect_one_line(call(learn(path("empty.log"))), 3, "empty.log");
  expect_one_line(call(learn(path("empty.log"), "mounts")), 2,
                  "--what: expected sensor, or some of mount,odometry,delay, got 'mounts'");
  expect_one_line(call(with(learn(path("empty.log")), {"--map", "m.yaml"})), 2,
                  "--map and --truth are for --what sensor");
  expect_one_line(call({"learn", "--log", path("empty.log")}), 2, "--map is required");
}

}  // namespace
}  // namespace parloc::test
