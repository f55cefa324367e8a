// `parloc locate` as a person or a script meets it: its answers, exit codes and files.
#include <gtest/gtest.h>

#include <cmath>

#include "common/map/map_reader.h"
#include "common/simulator/simulator.h"
#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

constexpr double kTurn_rad = 6.283185307179586;
const Pose kTruth{8.5, 4.0, -2.0};

std::string scan_yaml(const GridMap& map, const Pose& pose) {
  std::string text = "angle_min_deg: -180\nangle_step_deg: 2\nrange_min: 0.1\nrange_max: 30\nranges: [";
  for (int b = 0; b < 180; ++b) {
    const double angle_rad = pose.theta_rad - kTurn_rad / 2 + kTurn_rad * b / 180;
    text += std::to_string(cast_simulated_ray(map, pose.x_m, pose.y_m, angle_rad, 30.0).range_m) + ", ";
  }
  return text + ".nan]\n";
}

class LocateProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_locate_test");
    const GridMap fine = read_map("maps/fine/hall_obstacles.yaml");
    write("scan.yaml", scan_yaml(fine, kTruth));
    write("symmetric.yaml", scan_yaml(read_map("maps/fine/hall.yaml"), {6, 3.5, 0.5}));
    const std::string angles = "angle_min_deg: 0\nangle_step_deg: 1\n";
    write("blind.yaml", angles + "ranges: [.nan, .inf, 0]\n");
    write("typo.yaml", angles + "range_mox: 3\nranges: [1]\n");
    write("words.yaml", angles + "ranges: [1, two]\n");
    write("far_mount.yaml", angles + "mount: [0, 1e300, 0]\nranges: [1]\n");
    write("limits.yaml", angles + "range_min: 4\nrange_max: 3\nranges: [1]\n");
    write("empty.log", "# nothing\n");
  }
  static Args locate(const Args& more, const std::string& map = "maps/hall_obstacles.yaml") {
    return with({"locate", "--map", map, "--backend", "cpu"}, more);
  }
};

TEST_F(LocateProgram, FindsAScanOfAFileAndWritesWhatItFound) {
  const Json j = told(locate({"--scan", path("scan.yaml"), "--json", "--out", path("out")}));
  EXPECT_EQ(j["verdict"], "found");
  const Json& best = j["hypotheses"][0];
  EXPECT_LT(std::hypot(best["x_m"].get<double>() - kTruth.x_m, best["y_m"].get<double>() - kTruth.y_m), 0.07);
  EXPECT_NEAR(best["theta_rad"].get<double>(), kTruth.theta_rad, 0.01);
  EXPECT_GT(best["explained"].get<double>(), 0.9);
  EXPECT_EQ(json_of("out/hypotheses.json"), j);
  expect_png(path("out/picture.png"));
}

TEST_F(LocateProgram, SaysWhatIsAmbiguousAndTakesPriors) {
  const Args both = locate({"--scan", path("symmetric.yaml")}, "maps/hall.yaml");
  expect_parts(done(both).out, {"ambiguous: 2 places"});
  for (const Args& prior : {Args{"--near", "6,3,2"}, Args{"--heading", "0.4,0.5"}})
    expect_parts(done(with(with(both, {"--top", "1"}), prior)).out, {"found: one place"});
}

TEST_F(LocateProgram, TakesAScanFromALog) {
  const Args log{"--log", "maps/logs/malaga_corridor.log.gz", "--scan-number", "7"};
  const Outcome o = done(locate(log, "maps/malaga_corridor.yaml"));
  expect_parts(o.out, {"scan 7 of maps/logs/malaga_corridor.log.gz"});
}

TEST_F(LocateProgram, NothingFoundHasACodeOfItsOwn) {
  const Outcome blind = call(locate({"--scan", path("blind.yaml"), "--out", path("blind")}));
  EXPECT_EQ(blind.code, 7);
  expect_parts(blind.out, {"none"});
  EXPECT_TRUE(blind.err.empty()) << blind.err;
  EXPECT_EQ(json_of("blind/hypotheses.json")["verdict"], "none");
  EXPECT_EQ(call(locate({"--scan", path("scan.yaml")}, "maps/empty.yaml")).code, 7);  // a map without walls
}

TEST_F(LocateProgram, ErrorsAreOneLineWithACode) {
  const std::string scan = path("scan.yaml"), log = "maps/logs/malaga_corridor.log.gz";
  const ProgramCase cases[] = {
      {{}, 2, "expected a scan"},
      {{"--scan", scan, "--log", log}, 2, "not both"},
      {{"--scan", scan, "--at", "3"}, 2, "expected --log"},
      {{"--log", log, "--at", "3", "--scan-number", "2"}, 2, "not both"},
      {{"--log", log, "--scan-number", "0"}, 2, "from 1 up"},
      {{"--log", log, "--at", "-1"}, 2, "--at"},
      {{"--scan", scan, "--top", "0"}, 2, "--top"},
      {{"--scan", scan, "--near", "1,2"}, 2, "--near"},
      {{"--scan", scan, "--near", "1,2,-3"}, 2, "--near"},
      {{"--scan", scan, "--heading", "1,nan"}, 2, "--heading"},
      {{"--scan", scan, "--backend", "abacus"}, 2, "--backend"},
      {{"--scan", scan, "--near", "500,500,1"}, 3, "no free cell"},
      {{"--scan", path("missing.yaml")}, 3, "missing.yaml"},
      {{"--scan", path("typo.yaml")}, 3, "typo.yaml:3"},
      {{"--scan", path("words.yaml")}, 3, "number 2"},
      {{"--scan", path("far_mount.yaml")}, 3, "far_mount.yaml:3: mount"},
      {{"--scan", path("limits.yaml")}, 3, "limits.yaml:3: range_min"},
      {{"--log", path("empty.log")}, 3, "found none"},
      {{"--log", log, "--scan-number", "100000"}, 3, "expected 100000 scans"},
      {{"--log", log, "--at", "100000"}, 3, "ends before"},
      {{"--scan", scan, "--out", "/dev/null/x"}, 5, "/dev/null/x"},
  };
  for (const ProgramCase& c : cases) expect_error(call(locate(c.args)), c);
}

TEST_F(LocateProgram, HelpFitsAScreen) {
  const std::string help = done({"locate", "--help"}).out;
  EXPECT_LE(std::count(help.begin(), help.end(), '\n'), 24);
}

}  // namespace
}  // namespace parloc::test
