// The program as a person or a script meets it: exit codes, one line per error, results written whole or not
// at all.
#include <gtest/gtest.h>
#include <signal.h>

#include <sstream>

#include "common/io/trajectory.h"
#include "common/map/map_reader.h"
#include "tests/system/program_fixture.h"
#include "tests/unit/small_drive.h"

namespace parloc::test {
namespace {

namespace fs = std::filesystem;

constexpr int kScans = 40;

class Program : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_program_test");
    room = small_room();
    drive = small_drive(room, kScans);
    write_map(path("room.yaml"), room);
    write("drive.log", carmen_log_of(drive));
    write_tum(path("truth.tum"), drive.truth);
  }

  /// A small `parloc run` on the room; later arguments win over none of these, so leave out what is to be
  /// given.
  static Args run_args(const Args& more, const std::string& log = "drive.log",
                       const std::string& out = "out") {
    return with(
        {"run", "--map", path("room.yaml"), "--log", path(log), "--out", path(out), "--backend", "cpu"},
        more);
  }
  static Args with_truth(const Args& more = {}) {
    return with(run_args({"--truth", path("truth.tum"), "--particles", "300"}), more);
  }

  static inline GridMap room;
  static inline SmallDrive drive;
};

TEST_F(Program, LocalizesAndWritesEverything) {
  const Outcome outcome = done(with_truth());
  expect_parts(outcome.out, {"digest", path("out/report.html")});
  expect_parts(outcome.err, {"100 %"});  // plain progress lines: no terminal here
  expect_none_of(outcome.err, {"\r"});

  const Trajectory trajectory = read_tum(path("out/trajectory.tum"));
  ASSERT_EQ(trajectory.size(), static_cast<std::size_t>(kScans));
  for (int k = 0; k < kScans; ++k) EXPECT_DOUBLE_EQ(trajectory[k].stamp_s, drive.truth[k].stamp_s);
  expect_parts(read("out/trajectory.tum").substr(0, 400), {"100.000000 "});  // the first row

  expect_png(path("out/picture.png"));
  expect_parts(read("out/report.html"), {"</html>"});
  EXPECT_LT(json_of("out/metrics.json").at("position_max_m").get<double>(), 0.2);  // two cells
  expect_png(path("out/errors.png"));
  EXPECT_EQ(contents(path("out")).size(), 6u);  // nothing temporary is left
}

TEST_F(Program, JsonIsAllThatIsPrinted) {
  const Outcome outcome = done(with_truth({"--json", "--quiet", "--seed", "7", "--beams", "3"}));
  EXPECT_EQ(outcome.err, "");
  const Json metrics = Json::parse(outcome.out);
  for (const char* key :
       {"position_rmse_m", "position_mae_m", "position_max_m", "heading_rmse_rad", "heading_mae_rad", "steps",
        "scans", "wall_s", "step_ms_median", "step_ms_p99", "real_time_factor", "beams_used", "seed"}) {
    EXPECT_TRUE(metrics.at(key).is_number()) << key;
  }
  for (const char* reason : {"nan", "infinite", "negative", "zero", "below_min"}) {
    EXPECT_EQ(metrics.at("beams_rejected").at(reason), 0) << reason;
  }
  EXPECT_EQ(metrics.at("scans"), kScans);
  EXPECT_EQ(metrics.at("beams_used"), 3 * kScans);
  EXPECT_EQ(metrics.at("seed"), 7);
  EXPECT_EQ(metrics.at("config").at("scan").at("max_beams"), 3);
  EXPECT_EQ(metrics.at("interrupted"), false);
  expect_parts(metrics.at("backend"), {"cpu"});
  EXPECT_EQ(metrics.at("digest").get<std::string>().size(), 64u);
  EXPECT_TRUE(metrics.at("relations").is_null());
}

TEST_F(Program, WithoutTruthErrorsAreNull) {
  const Json metrics = told(run_args({"--init", "1,1,0", "--json", "--particles", "300"}));
  EXPECT_TRUE(metrics.at("position_rmse_m").is_null());
  EXPECT_TRUE(metrics.at("heading_mae_rad").is_null());
}

TEST_F(Program, OdometryOnlyMovesParticlesWithoutScans) {
  const auto figures = [&](const Args& more) {
    const Args alone = run_args({"--particles", "300", "--odometry-only", "--json"}, "drive.log", "alone");
    const Json metrics = told(with(alone, more));
    EXPECT_EQ(metrics.at("odometry_only"), true);
    EXPECT_EQ(metrics.at("beams_used"), 0);
    EXPECT_EQ(metrics.at("steps"), kScans);
    expect_png(path("alone/picture.png"));
    expect_parts(read("alone/report.html"), {"class=\"trail\""});
    return metrics;
  };
  const Json with_truth = figures({"--truth", path("truth.tum")});
  EXPECT_LT(with_truth.at("odometry").at("position_max_m").get<double>(), 1e-6);  // the drive's is exact
  expect_parts(read("alone/report.html"), {"Error in heading"});
  EXPECT_TRUE(fs::exists(path("alone/errors.png")));

  const Json without_truth = figures({"--init", "1,1,0"});
  EXPECT_TRUE(without_truth.at("odometry").is_null());
  expect_none_of(read("alone/report.html"), {"Error in heading"});
  EXPECT_FALSE(fs::exists(path("alone/errors.png")));  // nor is that of the run before left
}

TEST_F(Program, RelationsAreCompared) {
  const Pose delta = relative(drive.truth[20].pose, drive.truth[0].pose);
  std::ostringstream line;
  line.precision(9);
  line << std::fixed << drive.truth[0].stamp_s << ' ' << drive.truth[20].stamp_s << ' ' << delta.x_m << ' '
       << delta.y_m << " 0 0 0 " << delta.theta_rad << '\n';
  write("relations.txt", line.str());
  const Json relations = told(with_truth({"--relations", path("relations.txt"), "--json"})).at("relations");
  EXPECT_EQ(relations.at("compared"), 1);
  EXPECT_LT(relations.at("translation_mean_m").get<double>(), 0.2);
}

TEST_F(Program, SameSeedSameDigest) {
  const auto digest = [&](const Args& more) {
    return told(with_truth(more)).at("digest").get<std::string>();
  };
  const std::string one = digest({"--json", "--seed", "5", "--threads", "1"});
  EXPECT_EQ(digest({"--json", "--seed", "5", "--threads", "2"}), one);
  EXPECT_NE(digest({"--json", "--seed", "6", "--threads", "1"}), one);
}

TEST_F(Program, ErrorsAreOneLineAndDestroyNothing) {
  ASSERT_EQ(call(with_truth({"--quiet"})).code, 0);
  const auto before = contents(path("out"));
  write("a_file", "");
  write("no_scan.log", "ODOM 0 0 0 0 0 0 1.0 host 1.0\n");
  write("misspelt.yaml", "particles: 5\nsensor:\n  sigma_hitt: 1\n");
  write("type.yaml", "particles: many\n");
  write("value.yaml", "sensor:\n  tempering: 7\n");
  write("truncated.pgm", read("room.pgm").substr(0, 300));
  std::string yaml = read("room.yaml");
  write("truncated.yaml", yaml.replace(yaml.find("room.pgm"), 8, "truncated.pgm"));
  write("unknown_key.yaml", read("room.yaml") + "fre_thresh: 0.2\n");
  write("late.tum", "900.0 1 1 0 0 0 0 1\n");
  const std::string init = "--init=1,1,0";
  const auto on_map = [&](const std::string& map, const Args& more = {}) {
    const Args run{"run", "--map", path(map), "--log", path("drive.log"), "--out", path("out"), init};
    return with(run, more);
  };

  std::vector<ProgramCase> cases{
      {{}, 2, "--help"},
      {{"fly"}, 2, "--help"},
      {{"run"}, 2, "--log"},
      {run_args({init, "--partickles", "5"}), 2, "--partickles"},
      {run_args({init, "--particles", "0"}), 2,
       "--particles: expected a whole number from 1 to 16777216, got '0'"},
      {run_args({init, "--particles", "1e6"}), 2, "--particles: expected a whole number from 1 to 16777216"},
      {run_args({init, "--beams", "0"}), 2, "--beams: expected a whole number from 1 to 4096, got '0'"},
      {run_args({init, "--seed", "-1"}), 2, "--seed: expected a whole number from 0 to"},
      {run_args({init, "--seed", "18446744073709551616"}), 2, "--seed"},
      {run_args({init, "--seed", ""}), 2, "--seed"},
      {run_args({init, "--threads", "-2"}), 2, "--threads: expected a whole number from 0 to 1024, got '-2'"},
      {on_map("room.yaml", {"--backend", "gpu"}), 2, "--backend: gpu not in {auto,cpu,cuda}"},
      {run_args({}), 2, "--init"},
      {run_args({"--init", "1,2"}), 2, "--init 1,2"},
      {run_args({"--init", "nan,1,0"}), 2, "--init nan,1,0"},
      {run_args({"--init", "-3,1,0"}), 3, "inside the map"},
      {run_args({"--init", "60,1,0"}), 3, "inside the map"},
      {on_map("missing.yaml"), 3, "missing.yaml"},
      {on_map("truncated.yaml"), 3, "truncated.pgm"},
      {on_map("unknown_key.yaml"), 3,
       "unknown_key.yaml:8: unknown key 'fre_thresh'; the nearest valid key is 'free_thresh'"},
      {run_args({init}, "missing.log"), 3, "missing.log"},
      {run_args({init}, "no_scan.log"), 3, "expected at least one scan"},
      {run_args({init, "--truth", path("missing.tum")}), 3, "missing.tum"},
      {run_args({"--truth", path("late.tum")}), 3, "--init"},
      {run_args({init, "--relations", path("missing.txt")}), 3, "missing.txt"},
      {run_args({init, "--config", path("misspelt.yaml")}), 4,
       "misspelt.yaml:3: unknown key 'sensor.sigma_hitt'; the nearest valid key is 'sensor.sigma_hit'"},
      {run_args({init, "--config", path("type.yaml")}), 4,
       "type.yaml:1: particles: expected a whole number, got 'many'"},
      {run_args({init, "--config", path("value.yaml")}), 4, "value.yaml:2: sensor.tempering must be"},
      {run_args({init, "--config", path("none.yaml")}), 4, "none.yaml"},
      {run_args({init}, "drive.log", "a_file"), 5, "a_file"},
      {run_args({init}, "drive.log", "a_file/below"), 5, "a_file"},
      {{"map", "info", path("missing.yaml")}, 3, "missing.yaml"},
      {{"config", "--config", path("misspelt.yaml")}, 4, "sigma_hitt"},
      {{"simulate"}, 2, "--scenario"},
  };
  if (call({"devices"}).out.find("cuda: not in this build") != std::string::npos)
    cases.push_back({on_map("room.yaml", {"--backend", "cuda"}), 6, "cuda"});
  for (const ProgramCase& c : cases) expect_error(call(c.args), c);
  EXPECT_TRUE(contents(path("out")) == before);
}

TEST_F(Program, AFailedRunLeavesNoFolder) {
  EXPECT_EQ(call(run_args({"--init", "60,1,0"}, "drive.log", "new/deep/out")).code, 3);
  EXPECT_FALSE(fs::exists(path("new")));
}

TEST_F(Program, AFolderInTheWayIsSeenBeforeTheWork) {
  fs::create_directories(path("blocked/metrics.json"));
  const Outcome outcome = call(run_args({"--init", "1,1,0"}, "drive.log", "blocked"));
  EXPECT_EQ(outcome.code, 5);
  expect_parts(outcome.err, {"blocked/metrics.json"});
  expect_none_of(outcome.err, {"%"});  // no progress: no work was done
}

TEST_F(Program, StandardOutputThatIsFullIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const Outcome outcome = runner->finish(runner->start({"config"}, "/dev/full"));
  EXPECT_EQ(outcome.code, 5) << outcome.err;
}

TEST_F(Program, TroublesAreCountedAndFatalWhenStrict) {
  const auto log_with = [&](const std::function<void(std::vector<LogRecord>&)>& change) {
    SmallDrive changed = drive;
    change(changed.scans);
    return carmen_log_of(changed);
  };
  const auto with_range = [&](float range_m) {
    return log_with([&](auto& scans) { scans[5].scan.ranges_m[7] = range_m; });
  };
  std::string broken = carmen_log_of(drive);
  broken.insert(broken.find('\n') + 1, "FLASER 3 1.0 two 3.0 0 0 0 0 0 0 1 host 1\n");
  const struct {
    const char *group, *counter;  // in metrics.json
    std::string log;              // with this one trouble
  } troubles[] = {
      {"warnings", "broken_lines", broken},
      {"warnings", "backward_stamps", log_with([](auto& scans) { std::swap(scans[3], scans[4]); })},
      {"warnings", "beam_count_changes", log_with([](auto& scans) { scans[5].scan.ranges_m.pop_back(); })},
      {"warnings", "odometry_jumps", log_with([](auto& scans) { scans.back().odometry.x_m += 5; })},
      {"beams_rejected", "nan", with_range(NAN)},
      {"beams_rejected", "infinite", with_range(-INFINITY)},
      {"beams_rejected", "negative", with_range(-1.0f)},
      {"beams_rejected", "zero", with_range(0.0f)},
      {"beams_rejected", "below_min", with_range(0.01f)},
  };
  for (const auto& trouble : troubles) {
    SCOPED_TRACE(trouble.counter);
    const std::string name = std::string(trouble.counter) + ".log";
    write(name, trouble.log);
    const Args args = run_args({"--init", "1,1,0", "--json", "--quiet", "--particles", "300"}, name);
    EXPECT_GT(told(args).at(trouble.group).at(trouble.counter), 0);
    const Outcome strict = call(with(args, {"--strict"}));
    expect_one_line(strict, 3, name + ":");
    expect_parts(strict.err, {"--strict"});
  }
  EXPECT_EQ(call(run_args({"--init", "1,1,0", "--quiet", "--particles", "300", "--strict"})).code, 0);
}

TEST_F(Program, InterruptedRunsKeepWhatTheyHave) {
  // 40 scans of a million particles take seconds; the first progress line says that a tenth is done.
  for (const int signal_number : {SIGINT, SIGTERM}) {
    const Args many{"--init", "1,1,0", "--particles", "1000000", "--threads", "1", "--json"};
    const Outcome outcome = broken_off(run_args(many, "drive.log", "cut"), "%", signal_number);
    const std::size_t rows = read_tum(path("cut/trajectory.tum")).size();
    EXPECT_GE(rows, 1u);
    EXPECT_LT(rows, static_cast<std::size_t>(kScans));
    const Json metrics = Json::parse(outcome.out);
    EXPECT_EQ(metrics.at("interrupted"), true);
    EXPECT_EQ(metrics.at("scans"), rows);
    const std::string poses = read("cut/poses.csv");
    EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), static_cast<std::ptrdiff_t>(rows + 1));
    EXPECT_EQ(contents(path("cut")).size(), 5u);
  }
}

TEST_F(Program, SimulatedLogsAreLocalized) {
  write("path.yaml", "speed: 0.5\nturn_rate: 0.6\npoints:\n  - [1.0, 1.0]\n  - [3.0, 1.0]\n  - [3.0, 2.5]\n");
  const auto simulate = [&](const std::string& out, const std::string& seed) {
    const Outcome outcome = done({"simulate", "--map", path("room.yaml"), "--path", path("path.yaml"),
                                  "--out", path(out), "--seed", seed, "--quiet"});
    EXPECT_EQ(outcome.out + outcome.err, "");
    return read(out + "/scans.log");
  };
  const std::string log = simulate("sim", "3");
  EXPECT_EQ(simulate("sim_again", "3"), log);
  EXPECT_NE(simulate("sim_other", "4"), log);
  const Json metrics =
      told(run_args({"--truth", path("sim/truth.tum"), "--json"}, "sim/scans.log", "sim_out"));
  EXPECT_LT(metrics.at("position_max_m").get<double>(), 0.3);  // three cells, with noise
}

TEST_F(Program, PrintedConfigurationIsAConfiguration) {
  const std::string defaults = done({"config"}).out;
  write("defaults.yaml", defaults);
  EXPECT_EQ(done({"config", "--config", path("defaults.yaml")}).out, defaults);
}

TEST_F(Program, TakesTheSettingsOfNav2) {
  write("nav2.yaml",
        "/robot1/amcl:\n  ros__parameters:\n    set_initial_pose: true\n    initial_pose: {x: 1.0, y: 1.0, "
        "yaw: 0.0}\n"
        "    max_beams: 40\n    max_particles: 400\n    min_particles: 300\n    base_frame_id: base_link\n   "
        " sgima_hit: 1\n");
  const Outcome run = done(run_args({"--config", path("nav2.yaml"), "--json"}));
  expect_parts(run.err,
               {"nav2.yaml: nav2's settings of /robot1/amcl: 8 parameters taken; parloc config --config ",
                "nav2.yaml: 1 are no parameters of amcl: sgima_hit"});
  const Json config = Json::parse(run.out).at("config");
  EXPECT_EQ(config.at("scan").at("max_beams"), 40);
  EXPECT_EQ(config.at("max_particles"), 400);
  expect_parts(done({"config", "--config", path("nav2.yaml")}).out,
               {"# taken     max_beams: 40 -> scan.max_beams: 40\n",
                "# taken     base_frame_id: base_link -> log.base_frame: \"base_link\"\n",
                "# not used  sgima_hit: 1 -> no parameter of amcl; the nearest is 'sigma_hit'\n",
                "\n  max_beams: 40 "});
  // The listing is of comments: what is printed is a configuration of its own.
  write("translated.yaml", done({"config", "--config", path("nav2.yaml")}).out);
  EXPECT_EQ(done({"config", "--config", path("translated.yaml")}).out.find("amcl"), std::string::npos);
}

TEST_F(Program, EveryHelpFitsAScreen) {
  const Args none, info{"map", "info"}, check{"map", "check"}, convert{"map", "convert"}, show{"map", "show"};
  for (const Args& command :
       {none, Args{"run"}, Args{"simulate"}, Args{"map"}, info, check, convert, show, Args{"config"},
        Args{"evaluate"}, Args{"compare"}, Args{"slam"}, Args{"bench"}, Args{"devices"}}) {
    const Outcome outcome = done(with(command, {"--help"}));
    EXPECT_EQ(outcome.err, "");
    std::istringstream lines(outcome.out);
    std::string line;
    int count = 0;
    while (std::getline(lines, line)) {
      ++count;
      EXPECT_LE(line.size(), 80u) << line;
    }
    EXPECT_GT(count, 3) << outcome.out;
    EXPECT_LE(count, 24) << outcome.out;
  }
  EXPECT_EQ(call({"--version"}).out.rfind("parloc ", 0), 0u);
}

TEST_F(Program, LearnErrorsAreOneLine) {
  write("nothing.log", "");
  const Args learn{"learn",           "--map", path("room.yaml"), "--truth",
                   path("truth.tum"), "--out", path("learned"),   "--quiet"};
  expect_one_line(call(with(learn, {"--log", path("nothing.log")})), 3,
                  "nothing.log: expected at least 100 beams with a true pose");
  expect_one_line(call(with(learn, {"--log", path("drive.log"), "--beams", "0"})), 2,
                  "--beams: expected a whole number from 1 to 4096, got '0'");
  EXPECT_FALSE(fs::exists(path("learned")));
}

TEST_F(Program, TellsAboutDevices) {
  expect_parts(done({"devices"}).out, {"cpu"});
}

}  // namespace
}  // namespace parloc::test
