// `parloc compare` as a person or a script meets it: its tables and files, the same for any number of jobs,
// an interruption, and what is wrong on the command line.
#include <gtest/gtest.h>

#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

constexpr const char* kScenario = R"(lidar:
  beams: 90
  angle_min_deg: -180
  angle_step_deg: 4
  range_max: 8
  sigma_range: 0.02
odometry:
  rate: 20
  form: wheels
  kappa: 1e-5
scan_rate: 5
)";

class CompareProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_compare_test");
    const std::string maps = std::string(PARLOC_SOURCE_DIR) + "/maps/";
    const std::string drawn =
        "map: " + maps + "fine/hall_obstacles.yaml\npath: " + maps + "paths/hall_17m.yaml\n";
    const std::string map = "localization_map: " + maps + "hall_obstacles.yaml\n";
    write("hall.yaml", drawn + map + kScenario);
    write("mapless.yaml", drawn + kScenario);
    write("seed.yaml", drawn + map + "odometry: {form: seed}\n");
    write("elsewhen.tum", "5.0 1 1 0 0 0 0 1\n5.1 1 1 0 0 0 0 1\n");
    write("empty.log", "# nothing\n");
    write("nan.tum", "5.0 1 1 0 0 0 0 1\n5.1 nan 1 0 0 0 0 1\n");
    write("short.log", "FLASER 3 5 5 5 2 2 0 2 2 0 5.0 test 5.0\n");
    write("short.tum", "5.0 2 2 0 0 0 0 1\n");
    write("broken.yaml", "{map: [\n");
    write("bare.yaml",
          "image: bare.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
          "free_thresh: 0.196\n");
    write("bare.pgm", "P5\n9 9\n255\n" + std::string(81, '\xfe'));
  }
  static Args compare(const Args& args) { return with({"compare"}, args); }
  /// Small filters: the tests are of the program.
  static Args simulated(const Args& more) {
    return with(compare({"--scenario", path("hall.yaml"), "--filters", "mcl@200,ekf_beams,edh@20"}), more);
  }
  static Json result(const std::string& folder) { return json_of(folder + "/compare.json"); }
  /// Name -> content of all but what the last call printed.
  static std::map<std::string, std::string> kept_files() {
    auto files = contents(runner->folder());
    files.erase(path("stdout"));
    files.erase(path("stderr"));
    return files;
  }
};

TEST_F(CompareProgram, TheNumberOfJobsChangesNothing) {
  const Args short_drive = simulated({"--seeds", "3", "--duration", "8"});
  const Outcome a = done(with(short_drive, {"--out", path("one")}));
  const Outcome b = done(with(short_drive, {"--out", path("two"), "--jobs", "2", "--quiet"}));
  EXPECT_EQ(b.out + b.err, "");
  EXPECT_EQ(lasting(result("one")), lasting(result("two")));
  const Json j = result("one");
  ASSERT_EQ(j["filters"].size(), 3u);
  EXPECT_EQ(j["filters"][2]["filter"], "edh@20");
  EXPECT_EQ(j["filters"][2]["particles"], 20);
  EXPECT_TRUE(j["published"].is_null());
  for (const Json& filter : j["filters"]) {
    EXPECT_EQ(filter["runs"], 3);
    EXPECT_EQ(filter["lost"], 0);
    EXPECT_EQ(filter["each"][2]["seed"], 3);
    EXPECT_EQ(filter["each"][0]["scans"], 41);  // 8 s at 5 Hz, both ends
    EXPECT_LT(filter["position_rmse_m"]["mean"].get<double>(), 0.1);
    EXPECT_GT(filter["position_rmse_m"]["deviation"].get<double>(), 0.0);
  }
  EXPECT_GT(j["times"]["filters"][1]["real_time_factor"].get<double>(), 1.0);
  expect_parts(read("one/report.html"), {"</html>"});
  expect_none_of(read("one/report.html"), {"http"});  // nothing from elsewhere
  expect_parts(read("one/compare.md"), {"| edh@20 | 3 | 0 |"});
  expect_parts(a.out, {"edh@20"});
}

TEST_F(CompareProgram, ASeedAloneIsTheSameRun) {
  done(simulated({"--seeds", "2", "--duration", "4", "--out", path("all")}));
  done(simulated({"--seed", "2", "--seeds", "1", "--duration", "4", "--out", path("alone")}));
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(result("all")["filters"][k]["each"][1], result("alone")["filters"][k]["each"][0]);
}

// Who is carried off or told a wrong start does worse, and if it never finds back its errors are in no mean;
// who has better wheels does no worse than wild ones let.
TEST_F(CompareProgram, TroublesAreWhatTheySay) {
  const Args one = simulated({"--seeds", "1", "--duration", "12", "--out", path("trouble")});
  const auto maximum_m = [&](const Args& trouble) {
    done(with(one, trouble));
    return result("trouble")["filters"][1]["each"][0]["position_max_m"].get<double>();
  };
  const auto ekf_beams = [] { return result("trouble")["filters"][1]; };
  EXPECT_LT(maximum_m({}), 0.3);
  EXPECT_EQ(ekf_beams()["kept"], 1);
  EXPECT_TRUE(ekf_beams()["lost_s"]["mean"].is_null());
  EXPECT_GE(maximum_m({"--kidnap", "4,2"}), 1.5);
  EXPECT_EQ(result("trouble")["plan"]["kidnapping"]["distance_m"], 2.0);
  EXPECT_EQ(ekf_beams()["each"][0]["kidnapped_s"], 4.0);
  EXPECT_GE(maximum_m({"--start-error", "2,0", "--sigma", "0.01,0.01"}), 1.5);
  EXPECT_EQ(ekf_beams()["lost"], 1);
  EXPECT_EQ(ekf_beams()["kept"], 0);
  EXPECT_TRUE(ekf_beams()["position_rmse_m"]["mean"].is_null());
  EXPECT_EQ(ekf_beams()["lost_s"]["mean"], 0.0);
  EXPECT_EQ(ekf_beams()["away"], 1.0);
  EXPECT_GT(maximum_m({"--kappa", "1e-2"}), maximum_m({"--kappa", "0"}));
  maximum_m({"--people", "8"});
  EXPECT_GT(result("trouble")["plan"]["unmapped_hits"].get<double>(), 0.01);
}

TEST_F(CompareProgram, ARecordedLog) {
  done(with(compare(kLog),
            {"--filters", "mcl@500,ekf_beams", "--seeds", "2", "--duration", "5", "--out", path("log")}));
  const Json j = result("log");
  EXPECT_TRUE(j["plan"]["unmapped_hits"].is_null());
  EXPECT_EQ(j["filters"][1]["position_rmse_m"]["deviation"], 0.0);  // has no chance in it
  EXPECT_GT(j["filters"][0]["position_rmse_m"]["deviation"].get<double>(), 0.0);
}

TEST_F(CompareProgram, BrokenLinesOfALogAreTold) {
  write("broken.log", read("short.log") + "FLASER 3 1 nan\n");
  const Outcome o = done(compare({"--log", path("broken.log"), "--map", kLog[3], "--truth", path("short.tum"),
                                  "--filters", "ekf", "--seeds", "1"}));
  expect_parts(o.out, {"recorded, 1 broken line was skipped"});
}

TEST_F(CompareProgram, CtrlCKeepsWhatIsDone) {
  for (const char* jobs : {"1", "2"}) {
    // The first line of progress comes after a tenth of the work, or 10 s.
    const Outcome o = broken_off(compare({"--scenario", path("hall.yaml"), "--filters", "ekf,edh@20",
                                          "--seeds", "300", "--jobs", jobs, "--out", path("broken")}),
                                 "of 600 runs");
    const Json j = result("broken");
    EXPECT_TRUE(j["interrupted"]);
    EXPECT_GE(j["filters"][0]["runs"], 1);
    EXPECT_EQ(j["filters"][0]["runs"], j["filters"][0]["each"].size());
    expect_parts(o.out, {"interrupted"});
  }
}

TEST_F(CompareProgram, ErrorsAreOneLineWithACode) {
  const std::string log = kLog[1], map = kLog[3], truth = kLog[5];
  const auto with = [](const Args& more) { return test::with({"--scenario", path("hall.yaml")}, more); };
  const ProgramCase cases[] = {
      {{}, 2, "--scenario or --log"},
      {with({"--log", log}), 2, "not both"},
      {with({"--truth", truth}), 2, "expected --log"},
      {with({"--filters", "ekf,kalman"}), 2, "kalman"},
      {with({"--filters", "edh@x"}), 2, "'edh@x': expected a whole number of particles"},
      {with({"--filters", "edh@0"}), 2, "'edh@0': particles must be 1 to"},
      {with({"--filters", "edh@-1"}), 2, "'edh@-1': particles must be 1 to"},
      {with({"--filters", "ekf=" + path("hall.yaml")}), 4, "unknown key 'map'"},
      {with({"--filters", "ekf=" + path("broken.yaml")}), 4, "broken.yaml:"},
      {{"--scenario", path("broken.yaml")}, 4, "broken.yaml:"},
      {with({"--map", path("bare.yaml")}), 3, "no occupied cell"},
      {with({"--filters", "edh=" + path("missing.yaml")}), 4, "missing.yaml"},
      {with({"--config", path("missing.yaml")}), 4, "missing.yaml"},
      {with({"--seeds", "0"}), 2, "--seeds"},
      {with({"--seed", "-1"}), 2, "--seed"},
      {with({"--jobs", "0"}), 2, "--jobs"},
      {with({"--duration", "0"}), 2, "--duration"},
      {with({"--sigma", "0.1"}), 2, "two numbers"},
      {with({"--start-error", "1;2"}), 2, "two numbers"},
      {with({"--start-error", "1,nan"}), 2, "--start-error"},
      {with({"--filters", "ekf", "--start-error", "999,0"}), 3, "ekf, seed 1: start pose"},
      {with({"--kidnap", "-1,2"}), 2, "--kidnap"},
      {with({"--kidnap", "9..5,2"}), 2, "--kidnap"},
      {with({"--kidnap", "5..,2"}), 2, "--kidnap"},
      {with({"--kidnap", "5,5000"}), 3, "never gets 5000 m away"},
      {with({"--kidnap", "5000,1"}), 3, "a drive of more than 5000 s"},
      {with({"--kappa", "-1"}), 2, "--kappa"},
      {with({"--people", "x"}), 2, "--people"},
      {{"--scenario", path("seed.yaml"), "--kappa", "1e-4"}, 2, "form: wheels"},
      {with({"--map", path("missing.yaml")}), 3, "missing.yaml"},
      {{"--scenario", path("mapless.yaml")}, 2, "expected --map"},
      {{"--log", log, "--map", map}, 2, "--truth"},
      {{"--log", log, "--truth", truth}, 2, "--map"},
      {{"--log", log, "--map", map, "--truth", truth, "--kappa", "1e-4"}, 2, "simulated"},
      {{"--log", log, "--map", map, "--truth", path("missing.tum")}, 3, "missing.tum"},
      {{"--log", log, "--map", map, "--truth", path("elsewhen.tum")}, 3, "elsewhen.tum"},
      {{"--log", log, "--map", map, "--truth", path("empty.log")}, 3, "expected a pose"},
      {{"--log", log, "--map", map, "--truth", path("nan.tum")}, 3, "nan.tum:2: expected a finite position"},
      {{"--log", path("empty.log"), "--map", map, "--truth", truth}, 3, "found none"},
  };
  for (const ProgramCase& c : cases) {
    expect_error(call(test::with(compare(c.args), {"--out", path("out")})), c);
    EXPECT_TRUE(contents(path("out")).empty()) << c.words;
  }
}

TEST_F(CompareProgram, WhereItCannotWriteItLeavesAllAsItWas) {
  write("file", "mine");
  std::filesystem::create_directories(path("taken/report.html"));
  for (const std::string& folder : {std::string("/dev/null/x"), path("file"), path("taken")}) {
    const auto before = kept_files();
    const Args args = simulated({"--seeds", "1", "--duration", "1", "--quiet", "--out", folder});
    expect_one_line(call(args), 5, folder);
    EXPECT_EQ(kept_files(), before);
  }
}

}  // namespace
}  // namespace parloc::test
