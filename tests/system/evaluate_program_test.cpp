// `parloc evaluate` as a person or a script meets it: its table and files, the same for any number of jobs,
// an interruption, and what is wrong on the command line.
#include <gtest/gtest.h>

#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

constexpr const char* kScenario = R"(lidar:
  beams: 180
  angle_min_deg: -180
  angle_step_deg: 2
  range_max: 8
  sigma_range: 0.02
odometry:
  rate: 20
scan_rate: 5
seed: 1
)";

class EvaluateProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_evaluate_test");
    const std::string maps = std::string(PARLOC_SOURCE_DIR) + "/maps/";
    const std::string drawn =
        "map: " + maps + "fine/hall_obstacles.yaml\npath: " + maps + "paths/hall_17m.yaml\n";
    write("hall.yaml", drawn + "localization_map: " + maps + "hall_obstacles.yaml\n" + kScenario);
    write("mapless.yaml", drawn + kScenario);
    write("typo.yaml", drawn + kScenario + "lidor: 1\n");
    write("elsewhen.tum", "5.0 1 1 0 0 0 0 1\n5.1 1 1 0 0 0 0 1\n");
    write("empty.log", "# nothing\n");
  }
  static Args evaluate(const Args& args) { return with({"evaluate"}, args); }
  /// Few particles and short trials: the tests are of the program, not of the localizer.
  static Args simulated(const Args& more) {
    return evaluate(with({"--scenario", path("hall.yaml"), "--particles", "300", "--duration", "4"}, more));
  }
  static Json result(const std::string& folder) { return json_of(folder + "/evaluate.json"); }
};

TEST_F(EvaluateProgram, TheNumberOfJobsChangesNothing) {
  for (const std::string task : {"global", "kidnap"}) {
    const Args trials = simulated({"--task", task, "--trials", "3"});
    const Outcome one =
        done(with(trials, {"--jobs", "1", "--out", path("one"), "--samples", path("one.csv")}));
    const Outcome two =
        done(with(trials, {"--jobs", "2", "--out", path("two"), "--samples", path("two.csv"), "--quiet"}));
    EXPECT_EQ(two.out + two.err, "");
    EXPECT_EQ(lasting(result("one")), lasting(result("two")));
    EXPECT_EQ(read("one.csv"), read("two.csv"));
    const Json j = result("one");
    EXPECT_EQ(j["trials"].size(), 3u);
    EXPECT_EQ(j["trials"][2]["seed"], 3);
    EXPECT_EQ(j["summary"]["success"]["of"], 3);
    EXPECT_EQ(j["summary"].contains("noticed"), task == "kidnap");
    EXPECT_FALSE(j["interrupted"]);
    expect_parts(one.out, {"success"});
    expect_parts(read("one/report.html"), {"</html>"});
    expect_none_of(read("one/report.html"), {"http"});  // nothing from elsewhere
  }
}

// Told its start, even a small filter follows: an error of decimetres would be one of the comparison.
TEST_F(EvaluateProgram, ASeedAloneIsTheSameTrial) {
  done(simulated({"--task", "track", "--trials", "3", "--out", path("all")}));
  done(simulated({"--task", "track", "--trials", "1", "--seed", "3", "--out", path("alone"), "--samples",
                  path("alone.csv")}));
  EXPECT_EQ(result("all")["trials"][2], result("alone")["trials"][0]);
  EXPECT_EQ(result("all")["summary"]["success"]["hits"], 3);
  EXPECT_LT(result("all")["summary"]["rmse_m"].get<double>(), 0.1);
  const std::string csv = read("alone.csv");
  EXPECT_EQ(
      csv.rfind("seed,stamp_s,position_error_m,heading_error_rad,right,evidence,share,probability,state", 0),
      0u);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 21);  // 4 s at 5 Hz, both ends
}

TEST_F(EvaluateProgram, StartsInALog) {
  const Args starts = evaluate(with(kLog, {"--starts", "4", "--duration", "3", "--particles", "500"}));
  done(with(starts, {"--out", path("log")}));
  const Json j = result("log");
  ASSERT_EQ(j["trials"].size(), 4u);
  const double first_s = j["trials"][0]["begun_s"], last_s = j["trials"][3]["begun_s"];
  EXPECT_NEAR(last_s - first_s, 0.75 * 59.0, 1.5);  // the log has 59 s and a scan every second or less
  done(with(starts, {"--out", path("third"), "--seed", "3", "--trials", "1"}));
  EXPECT_EQ(result("third")["trials"][0], j["trials"][2]);
  EXPECT_TRUE(j["summary"]["unmapped"].is_null());
}

TEST_F(EvaluateProgram, CtrlCKeepsWhatIsDone) {
  const Args args = evaluate({"--scenario", path("hall.yaml"), "--particles", "300", "--duration", "2",
                              "--trials", "300", "--jobs", "2", "--out", path("broken")});
  const Outcome o = broken_off(args, "of 300 trials");  // the first line comes after a tenth of the work
  const Json j = result("broken");
  EXPECT_TRUE(j["interrupted"]);
  EXPECT_GE(j["trials"].size(), 1u);
  EXPECT_EQ(j["summary"]["trials"], j["trials"].size());
  expect_parts(o.out, {"interrupted, 300 were wanted"});
}

TEST_F(EvaluateProgram, ErrorsAreOneLineWithACode) {
  const Args scenario{"--scenario", path("hall.yaml")};
  const std::string log = kLog[1], map = kLog[3], truth = kLog[5];
  const ProgramCase cases[] = {
      {{}, 2, "--scenario or --log"},
      {with(scenario, {"--log", log}), 2, "not both"},
      {with(scenario, {"--trials", "0"}), 2, "--trials"},
      {with(scenario, {"--trials", "-3"}), 2, "--trials"},
      {with(scenario, {"--trials", "many"}), 2, "--trials"},
      {with(scenario, {"--task", "dance"}), 2, "--task: dance not in {global,kidnap,track}"},
      {with(scenario, {"--jobs", "0"}), 2, "--jobs"},
      {with(scenario, {"--particles", "0"}), 2, "--particles: expected a whole number from 1 to 16777216"},
      {with(scenario, {"--range", "nan"}), 2, "--range"},
      {with(scenario, {"--fov", "0"}), 2, "--fov"},
      {with(scenario, {"--duration", "0"}), 2, "--duration"},
      {with(scenario, {"--limit", "-1"}), 2, "--limit"},
      {with(scenario, {"--seed", "-1"}), 2, "--seed"},
      {with(scenario, {"--starts", "3"}), 2, "expected --log"},
      {with(scenario, {"--map", path("missing.yaml")}), 3, "missing.yaml"},
      {with(scenario, {"--config", path("missing.yaml")}), 4, "missing.yaml"},
      {with(scenario, {"--out", "/dev/null/x"}), 5, "/dev/null/x"},
      {with(scenario, {"--samples", "/dev/null/x.csv"}), 5, "/dev/null/x.csv"},
      {{"--scenario", path("mapless.yaml")}, 2, "expected --map"},
      {{"--scenario", path("typo.yaml")}, 4, "typo.yaml"},
      {{"--log", log, "--map", map}, 2, "--truth"},
      {{"--log", log, "--truth", truth}, 2, "--map"},
      {{"--log", log, "--map", map, "--truth", path("missing.tum")}, 3, "missing.tum"},
      {{"--log", log, "--map", map, "--truth", path("elsewhen.tum")}, 3, "elsewhen.tum"},
      {{"--log", path("empty.log"), "--map", map, "--truth", truth}, 3, "found none"},
      {{"--log", log, "--map", map, "--truth", truth, "--task", "kidnap"}, 2, "simulated"},
      {{"--log", log, "--map", map, "--truth", truth, "--range", "5"}, 2, "simulated"},
      {{"--log", log, "--map", map, "--truth", truth, "--starts", "3", "--seed", "4"}, 2, "from 1 to 3"},
  };
  for (const ProgramCase& c : cases) expect_error(call(evaluate(c.args)), c);
}

}  // namespace
}  // namespace parloc::test
