// `parloc bench` as a person or a script meets it.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <sstream>

#include "tests/system/program_fixture.h"

#if defined(__linux__)
#include <sched.h>
#endif

namespace parloc::test {
namespace {

namespace fs = std::filesystem;

class BenchProgram : public ProgramSuite {
 protected:
  void SetUp() override { open("parloc_bench_program_test"); }  // an empty folder for each

  /// Rows of milliseconds.
  static Args small(const Args& more, const std::string& out = "out") {
    return with(
        {"bench", "--seconds", "0.001", "--max-particles", "500", "--max-beams", "50", "--out", path(out)},
        more);
  }
  static Json written(const std::string& out = "out") { return json_of(out + "/bench.json"); }
};

TEST_F(BenchProgram, QuickEndsSoonAndWritesEverything) {
  const auto begun = std::chrono::steady_clock::now();
  const Outcome outcome = done({"bench", "--quick", "--max-particles", "1000", "--out", path("out")});
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20));
  expect_parts(outcome.err, {"%"});
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(path("out")) == std::string::npos) {
      EXPECT_LE(line.size(), 100u) << line;
    }
  }
  expect_parts(outcome.out, {"dual core", "GTX 560", "Opteron", "no_hit", "hall_obstacles", "500x50",
                             "0.0241*", "ratio", "p99", "bench.html"});
  const Json json = written();
  EXPECT_EQ(json.at("interrupted"), false);
  EXPECT_EQ(json.at("quick"), true);
  EXPECT_GT(json.at("rows").size(), 0u);
  expect_parts(json.at("command"), {"bench --quick"});
  expect_parts(read("out/bench.html"), {"</html>"});
  expect_parts(read("out/bench.md"), {"| 500x50 |"});
  EXPECT_EQ(contents(path("out")).size(), 3u);  // nothing temporary is left
}

TEST_F(BenchProgram, JsonIsAllThatIsPrinted) {
  const Outcome outcome = done(small({"--json", "--quiet", "--scene", "hall,office", "--cloud", "global"}));
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.out, read("out/bench.json"));
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json.at("scenes").size(), 2u);
  for (const Json& row : json.at("rows")) EXPECT_EQ(row.at("cloud"), "global");
}

TEST_F(BenchProgram, ScaleRuns) {
  const Outcome outcome = done({"bench", "--scale", "--quick", "--seconds", "0.001", "--scene", "no_hit",
                                "--max-particles", "8192", "--max-beams", "100", "--out", path("out")});
  expect_parts(outcome.out, {"Stages", "normalise_scan", "bytes/s", "budget", "40 ms"});
  EXPECT_EQ(written().at("mode"), "scale");
  EXPECT_GE(written().at("largest").size(), 3u);
}

TEST_F(BenchProgram, InterruptedKeepsFinishedRows) {
  // The first lines of progress come when a tenth of the rows is done, seconds before the end.
  for (const int signal_number : {SIGINT, SIGTERM}) {
    const Args args{"bench", "--seconds", "0.3", "--scene", "no_hit", "--out", path("cut")};
    expect_parts(broken_off(args, "500x100", signal_number).out, {"interrupted"});
    const Json json = written("cut");
    EXPECT_EQ(json.at("interrupted"), true);
    EXPECT_GE(json.at("rows").size(), 1u);
    EXPECT_LT(json.at("rows").size(), 30u);
    expect_parts(read("cut/bench.html"), {"interrupted"});
    expect_parts(read("cut/bench.md"), {"interrupted"});
    EXPECT_EQ(contents(path("cut")).size(), 3u);
  }
}

TEST_F(BenchProgram, InterruptedAtOnceWritesNothing) {
  const pid_t child = runner->start({"bench", "--seconds", "30", "--scene", "no_hit", "--out", path("none")});
  for (int k = 0; k < 600 && !fs::exists(path("none")); ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // the first row takes half a minute
  kill(child, SIGINT);
  const Outcome outcome = runner->finish(child);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  expect_parts(outcome.err, {"nothing is written"});
  EXPECT_FALSE(fs::exists(path("none")));
}

TEST_F(BenchProgram, ErrorsAreOneLineBeforeAnyWork) {
  write("a_file", "");
  fs::create_directories(path("empty"));
  fs::create_directories(path("in_the_way/bench.md"));
  const auto bench = [](const Args& args) { return with({"bench"}, args); };
  const ProgramCase cases[] = {
      {small({"--scene", "cellar"}), 2, "no_hit, hall, hall_obstacles, hall_segments, office, got 'cellar'"},
      {small({"--scene", "hall,"}), 2, "--scene"},
      {small({"--cloud", "none"}), 2, "--cloud"},
      {small({"--algorithm", "best"}), 2, "paz2012, parloc, got 'best'"},
      {small({"--threads", "-1"}), 2, "--threads"},
      {small({"--threads", "5000"}), 2, "--threads: expected a whole number from 0 to 1024, got '5000'"},
      {bench({"--max-particles", "499"}), 2,
       "--max-particles: expected a whole number from 500 to 16777216, got '499'"},
      {bench({"--scale", "--max-particles", "500"}), 2,
       "--max-particles: expected a whole number from 1024 to"},
      {bench({"--max-beams", "4097"}), 2, "--max-beams: expected a whole number from 50 to 4096"},
      {bench({"--seconds", "nan"}), 2, "--seconds: expected a number from 0.001 to 3600"},
      {bench({"--seconds", "1s"}), 2, "--seconds: expected a number from 0.001 to 3600"},
      {bench({"--scale", "--algorithm", "published"}), 2, "--scale measures parloc only"},
      {bench({"--fast"}), 2, "--fast"},
      {small({"--maps", path("none")}), 3, "none"},
      {small({"--maps", path("empty")}), 3, "hall_obstacles.yaml"},
      {small({}, "a_file"), 5, "a_file"},
      {small({}, "a_file/below"), 5, "a_file"},
      {small({}, "in_the_way"), 5, "bench.md"},
  };
  for (const ProgramCase& c : cases) expect_error(call(c.args), c);  // one line: so no progress either
}

TEST_F(BenchProgram, FolderWithoutWritePermission) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  fs::create_directories(path("locked"));
  fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  const Outcome outcome = call(small({}, "locked"));
  fs::permissions(path("locked"), fs::perms::owner_all);
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  expect_none_of(outcome.err, {"%"});
}

TEST_F(BenchProgram, WithoutAGpuItSaysSo) {
  if (call({"devices"}).out.find("cuda 0:") != std::string::npos) GTEST_SKIP() << "there is a GPU";
  expect_parts(done(small({"--scene", "no_hit"})).out, {"- no GPU is measured"});
}

TEST_F(BenchProgram, OnOneCore) {
#if defined(__linux__)
  const pid_t child = runner->start(small({"--scene", "no_hit"}), "", [] {
    cpu_set_t allowed, one;
    CPU_ZERO(&one);
    sched_getaffinity(0, sizeof(allowed), &allowed);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
      if (CPU_ISSET(cpu, &allowed)) CPU_SET(cpu, &one);
    sched_setaffinity(0, sizeof(one), &one);
  });
  const Outcome outcome = runner->finish(child);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_parts(outcome.out, {"only one thread is measured"});
  EXPECT_EQ(written().at("machine").at("cores"), 1);
  for (const Json& variant : written().at("variants")) {
    if (variant.at("backend") == "cpu") {
      EXPECT_EQ(variant.at("threads"), 1);
    }
  }
#else
  GTEST_SKIP() << "no sched_setaffinity";
#endif
}

TEST_F(BenchProgram, WithTooLittleMemoryItSaysWhatItSkipped) {
  // A million particles need 200 MB, a quarter of them 100 MB. A thread's stack and arena and the libraries
  // take address space, too: one thread.
  const Args args{"bench",   "--scale",     "--scene", "no_hit",    "--seconds", "0.001", "--max-particles",
                  "1048576", "--max-beams", "50",      "--threads", "1",         "--out", path("out")};
  const pid_t child = runner->start(args, "", [] {
    const rlimit limit{200'000'000, 200'000'000};
    setrlimit(RLIMIT_AS, &limit);
  });
  const Outcome outcome = runner->finish(child);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_parts(outcome.out, {"skipped no_hit, tracking, 1048576 x 50", "GB of memory"});
  EXPECT_GT(written().at("rows").size(), 4u);  // the smaller ones are there
}

}  // namespace
}  // namespace parloc::test
