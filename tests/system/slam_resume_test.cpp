// `parloc slam` broken off by a signal, by a kill, and again on the way: with --resume it ends with the bytes
// of a run that was not.
#include <gtest/gtest.h>

#include "common/io/trajectory.h"
#include "tests/system/program_fixture.h"
#include "tests/unit/small_drive.h"

namespace parloc::test {
namespace {

namespace fs = std::filesystem;

constexpr int kScans = 200;

class SlamResume : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_slam_resume_test");
    const SmallDrive drive = small_drive(small_room(), kScans);
    write("drive.log", carmen_log_of(drive));
    SmallDrive other = drive;
    other.scans[1].scan.ranges_m[7] += 0.01f;
    write("other.log", carmen_log_of(other));
    // A slow matcher: the whole takes seconds, so that there is time to break it off.
    write("slow.yaml", "slam:\n  update_min_d: 0.01\n  iterations: 20\n  max_beams: 61\n  particles: 20\n");
  }
  static Args args(const std::string& out, const Args& more = {}) {
    return with({"slam", "--log", path("drive.log"), "--backend", "cpu", "--quiet", "--out", path(out)},
                more);
  }
  static Args fresh(const std::string& out, const Args& more = {}) {
    return with(args(out, {"--config", path("slow.yaml"), "--threads", "1"}), more);
  }
  static std::size_t hidden_in(const std::string& out) {
    std::size_t hidden = 0;
    for (const fs::directory_entry& e : fs::directory_iterator(path(out)))
      hidden += e.path().filename().string().front() == '.' ? 1 : 0;
    return hidden;
  }
  /// Broken off when there is a checkpoint, of which it writes one every now and then.
  static int code_of_broken_off(const Args& args, const std::string& out, int signal_number) {
    const pid_t child = runner->start(with(args, {"--checkpoint-every", "0.1"}));
    for (int k = 0; k < 6000 && !fs::exists(path(out + "/checkpoint")); ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_TRUE(fs::exists(path(out + "/checkpoint")));
    kill(child, signal_number);
    return runner->finish(child).code;
  }
  static void expect_same_results(const std::string& a, const std::string& b) {
    for (const char* name : {"/map.pgm", "/map.yaml", "/trajectory.tum"}) {
      EXPECT_FALSE(read(a + name).empty()) << name;
      EXPECT_TRUE(read(a + name) == read(b + name)) << name;
    }
    EXPECT_EQ(json_of(a + "/metrics.json").at("digest"), json_of(b + "/metrics.json").at("digest"));
    EXPECT_FALSE(fs::exists(path(b + "/checkpoint")));
    EXPECT_EQ(moments_of(a), moments_of(b));
  }
  /// When the pictures of the growing map in the report are from.
  static std::vector<std::string> moments_of(const std::string& out) {
    const std::string page = read(out + "/report.html"), key = "time in the log";
    std::vector<std::string> moments;
    for (std::size_t at = 0; (at = page.find(key, at)) != std::string::npos; at += key.size())
      moments.push_back(page.substr(at, 60));
    EXPECT_GT(moments.size(), 10u);
    return moments;
  }
};

TEST_F(SlamResume, EndsAsIfThereHadBeenNoBreak) {
  done(fresh("whole"));
  EXPECT_FALSE(fs::exists(path("whole/checkpoint")));

  // Ctrl-C: a map, and a checkpoint.
  ASSERT_EQ(code_of_broken_off(fresh("cut"), "cut", SIGINT), 130);
  const std::size_t rows = read_tum(path("cut/trajectory.tum")).size();
  EXPECT_LT(rows, static_cast<std::size_t>(kScans));
  EXPECT_EQ(json_of("cut/metrics.json").at("interrupted"), true);
  EXPECT_EQ(contents(path("cut")).size(), 7u);
  fs::copy(path("cut"), path("cut_again"));

  // Into another folder; a checkpoint that is read stays.
  done(args("resumed", {"--resume", path("cut"), "--threads", "2"}));
  EXPECT_EQ(json_of("resumed/metrics.json").at("resumed_at"), rows);
  EXPECT_EQ(json_of("resumed/metrics.json").at("scans"), kScans);
  expect_same_results("whole", "resumed");
  EXPECT_TRUE(fs::exists(path("cut/checkpoint")));

  // Killed on the way, and gone on from what was written every now and then, in the same folder.
  fs::remove(path("killed/checkpoint"));
  EXPECT_EQ(code_of_broken_off(args("killed", {"--resume", path("cut/checkpoint")}), "killed", SIGKILL), -1);
  EXPECT_EQ(hidden_in("killed"), 1u);
  done({"slam", "--log", path("drive.log"), "--resume", path("killed"), "--quiet"});
  EXPECT_GT(json_of("killed/metrics.json").at("resumed_at"), rows);
  expect_same_results("whole", "killed");
  EXPECT_EQ(hidden_in("killed"), 0u) << "what the killed run left behind";
}

TEST_F(SlamResume, WhatDoesNotFitIsOneLine) {
  ASSERT_EQ(code_of_broken_off(fresh("fits"), "fits", SIGTERM), 130);
  const std::string good = read("fits/checkpoint");
  write("short", good.substr(0, good.size() / 2));
  write("faster.yaml", "slam:\n  iterations: 4\n");
  fs::create_directories(path("empty"));
  const auto resume = [&](const std::string& log, const Args& more) {
    return with({"slam", "--log", path(log), "--quiet", "--out", path("none")}, more);
  };
  const Args fits{"--resume", path("fits")};
  const ProgramCase cases[] = {
      {resume("other.log", fits), 3, "other.log: expected the log of the checkpoint"},
      {resume("drive.log", {"--resume", path("empty")}), 3, "empty/checkpoint: cannot be opened"},
      {resume("drive.log", {"--resume", path("drive.log")}), 3, "expected a checkpoint of parloc slam"},
      {resume("drive.log", {"--resume", path("short")}), 3, "damaged or cut short"},
      {resume("drive.log", with(fits, {"--seed", "2"})), 2, "seed is 1 there and 2 here"},
      {resume("drive.log", with(fits, {"--particles", "30"})), 2, "slam.particles is 20 there and 30 here"},
      {resume("drive.log", with(fits, {"--config", path("faster.yaml")})), 2, "slam.iterations is 20 there"},
      {resume("drive.log", with(fits, {"--checkpoint-every", "-1"})), 2, "--checkpoint-every"},
  };
  for (const ProgramCase& c : cases) expect_error(call(c.args), c);
  EXPECT_FALSE(fs::exists(path("none")));
  // The settings that it was made with are no contradiction.
  done(with(fresh("same"), fits));
}

TEST_F(SlamResume, ALogThatEndsTooEarlyIsAnotherLog) {
  const pid_t child = runner->start(fresh("late", {"--checkpoint-every", "0"}));
  while (!fs::exists(path("late"))) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(child, SIGINT);
  const Outcome cut = runner->finish(child);
  ASSERT_EQ(cut.code, 130) << cut.err;
  ASSERT_TRUE(fs::exists(path("late/checkpoint"))) << cut.err;
  const std::string log = read("drive.log");
  write("one.log", log.substr(0, log.find('\n') + 1));
  expect_one_line(call({"slam", "--log", path("one.log"), "--resume", path("late"), "--quiet"}), 3,
                  "one.log: expected the log of the checkpoint");
}

}  // namespace
}  // namespace parloc::test
