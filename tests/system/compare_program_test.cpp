// `parloc compare` as a person or a script meets it: its tables and files, the same for any number of jobs,
// an interruption, and what is wrong on the command line.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

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
    write_file(runner->folder() / "hall.yaml", drawn + map + kScenario);
    write_file(runner->folder() / "mapless.yaml", drawn + kScenario);
    write_file(runner->folder() / "seed.yaml", drawn + map + "odometry: {form: seed}\n");
    write_file(runner->folder() / "elsewhen.tum", "5.0 1 1 0 0 0 0 1\n5.1 1 1 0 0 0 0 1\n");
    write_file(runner->folder() / "empty.log", "# nothing\n");
    write_file(runner->folder() / "nan.tum", "5.0 1 1 0 0 0 0 1\n5.1 nan 1 0 0 0 0 1\n");
    write_file(runner->folder() / "short.log", "FLASER 3 5 5 5 2 2 0 2 2 0 5.0 test 5.0\n");
    write_file(runner->folder() / "short.tum", "5.0 2 2 0 0 0 0 1\n");
    write_file(runner->folder() / "broken.yaml", "{map: [\n");
    write_file(runner->folder() / "bare.yaml",
               "image: bare.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
               "free_thresh: 0.196\n");
    write_file(runner->folder() / "bare.pgm", "P5\n9 9\n255\n" + std::string(81, '\xfe'));
  }
  static Outcome compare(const Args& args, const Args& more = {}) {
    return call(with(with({"compare"}, args), more));
  }
  /// Small filters: the tests are of the program.
  static Outcome simulated(const Args& more) {
    return compare({"--scenario", path("hall.yaml"), "--filters", "mcl@200,ekf_beams,edh@20"}, more);
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
  const Args short_drive{"--seeds", "3", "--duration", "8"};
  Args one = short_drive, two = short_drive;
  one.insert(one.end(), {"--out", path("one")});
  two.insert(two.end(), {"--out", path("two"), "--jobs", "2", "--quiet"});
  const Outcome a = simulated(one), b = simulated(two);
  ASSERT_EQ(a.code, 0) << a.err;
  ASSERT_EQ(b.code, 0) << b.err;
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
  const std::string page = read_file(path("one/report.html"));
  EXPECT_NE(page.find("</html>"), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos);  // nothing from elsewhere
  EXPECT_NE(read_file(path("one/compare.md")).find("| edh@20 | 3 | 0 |"), std::string::npos);
  EXPECT_NE(a.out.find("edh@20"), std::string::npos);
}

TEST_F(CompareProgram, ASeedAloneIsTheSameRun) {
  ASSERT_EQ(simulated({"--seeds", "2", "--duration", "4", "--out", path("all")}).code, 0);
  ASSERT_EQ(simulated({"--seed", "2", "--seeds", "1", "--duration", "4", "--out", path("alone")}).code, 0);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(result("all")["filters"][k]["each"][1], result("alone")["filters"][k]["each"][0]);
}

// Who is carried off or told a wrong start does worse, and if it never finds back its errors are in no mean;
// who has better wheels does no worse than wild ones let.
TEST_F(CompareProgram, TroublesAreWhatTheySay) {
  const Args one{"--seeds", "1", "--duration", "12", "--out", path("trouble")};
  const auto maximum_m = [&](const Args& trouble) {
    Args args = one;
    args.insert(args.end(), trouble.begin(), trouble.end());
    const Outcome o = simulated(args);
    EXPECT_EQ(o.code, 0) << o.err;
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
  Args args = kLog;
  args.insert(args.end(),
              {"--filters", "mcl@500,ekf_beams", "--seeds", "2", "--duration", "5", "--out", path("log")});
  const Outcome o = compare(args);
  ASSERT_EQ(o.code, 0) << o.err;
  const Json j = result("log");
  EXPECT_TRUE(j["plan"]["unmapped_hits"].is_null());
  EXPECT_EQ(j["filters"][1]["position_rmse_m"]["deviation"], 0.0);  // has no chance in it
  EXPECT_GT(j["filters"][0]["position_rmse_m"]["deviation"].get<double>(), 0.0);
}

TEST_F(CompareProgram, BrokenLinesOfALogAreTold) {
  write_file(path("broken.log"), read_file(path("short.log")) + "FLASER 3 1 nan\n");
  const Outcome o = compare({"--log", path("broken.log"), "--map", kLog[3], "--truth", path("short.tum"),
                             "--filters", "ekf", "--seeds", "1"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("recorded, 1 broken line was skipped"), std::string::npos) << o.out;
}

TEST_F(CompareProgram, CtrlCKeepsWhatIsDone) {
  for (const char* jobs : {"1", "2"}) {
    const pid_t child = runner->start({"compare", "--scenario", path("hall.yaml"), "--filters", "ekf,edh@20",
                                       "--seeds", "300", "--jobs", jobs, "--out", path("broken")});
    runner->wait_for("of 600 runs");  // the first line of progress comes after a tenth of the work, or 10 s
    kill(child, SIGINT);
    const Outcome o = runner->finish(child);
    EXPECT_EQ(o.code, 130) << o.err;
    const Json j = result("broken");
    EXPECT_TRUE(j["interrupted"]);
    EXPECT_GE(j["filters"][0]["runs"], 1);
    EXPECT_EQ(j["filters"][0]["runs"], j["filters"][0]["each"].size());
    EXPECT_NE(o.out.find("interrupted"), std::string::npos) << o.out;
  }
}

TEST_F(CompareProgram, ErrorsAreOneLineWithACode) {
  const Args scenario{"--scenario", path("hall.yaml")};
  const std::string log = kLog[1], map = kLog[3], truth = kLog[5];
  const auto with = [&](const Args& more) {
    Args args = scenario;
    args.insert(args.end(), more.begin(), more.end());
    return args;
  };
  struct Case {
    Args args;
    int code;
    const char* words;
  };
  const Case cases[] = {
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
  for (const Case& c : cases) {
    const Outcome o = compare(c.args, {"--out", path("out")});
    EXPECT_EQ(o.code, c.code) << o.err << o.out;
    EXPECT_NE(o.err.find(c.words), std::string::npos) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_TRUE(contents(path("out")).empty()) << c.words;
  }
}

TEST_F(CompareProgram, WhereItCannotWriteItLeavesAllAsItWas) {
  write_file(path("file"), "mine");
  std::filesystem::create_directories(path("taken/report.html"));
  for (const std::string& folder : {std::string("/dev/null/x"), path("file"), path("taken")}) {
    const auto before = kept_files();
    const Outcome o = simulated({"--seeds", "1", "--duration", "1", "--quiet", "--out", folder});
    EXPECT_EQ(o.code, 5) << folder;
    EXPECT_NE(o.err.find(folder), std::string::npos) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_EQ(kept_files(), before);
  }
}

TEST_F(CompareProgram, HelpFitsAScreen) {
  const Outcome o = compare({"--help"});
  EXPECT_EQ(o.code, 0);
  EXPECT_LE(std::count(o.out.begin(), o.out.end(), '\n'), 24);
}

}  // namespace
}  // namespace parloc::test
