// The parts of `parloc compare`: what is compared, on which logs, from which start, and what a run says.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "common/config/config.h"
#include "common/config/pose_filters.h"
#include "common/error.h"
#include "common/math/portable64.h"
#include "common/model/motion.h"
#include "tests/unit/simulated.h"
#include "tests/unit/small_drive.h"
#include "tests/unit/temp_file.h"
#include "tools/compare/comparison.h"
#include "tools/program/run_items.h"

namespace parloc::tools::compare {
namespace {

TrialLog small_log(int scans) {
  const auto drive = test::small_drive(test::small_room(), scans);
  return {drive.scans, drive.truth, 0.0, 0, 0};
}

// ---- filters ----------------------------------------------------------------------------------------------
TEST(CompareEntries, OwnSettingsGoOverTheCommonOnes) {
  const test::TempFile own("own.yaml", "scan: {max_beams: 33}\nmin_particles: 7\nmax_particles: 70\n");
  Config base;
  base.motion.alpha1 = 0.7;
  base.scan.max_beams = 44;
  const auto entries = read_entries("ekf,edh@10,mcl=" + own.path() + ",mcl@500=" + own.path(), base);
  ASSERT_EQ(entries.size(), 4u);
  EXPECT_EQ(entries[0].label, "ekf");
  EXPECT_EQ(entries[1].label, "edh@10");
  EXPECT_EQ(entries[1].config.particles, 10);
  EXPECT_EQ(entries[1].config.scan.max_beams, 44);
  EXPECT_EQ(entries[2].kind, "mcl");
  EXPECT_EQ(entries[2].label.rfind("mcl:parloc_", 0), 0u) << entries[2].label;  // the file's name
  EXPECT_EQ(entries[2].label + "@500", entries[3].label);
  EXPECT_EQ(entries[2].config.scan.max_beams, 33);
  EXPECT_EQ(entries[2].config.max_particles, 70);
  EXPECT_EQ(entries[3].config.most_particles(), 500);  // replaces those of the file, too
  for (const Entry& e : entries) {
    EXPECT_EQ(e.config.motion.alpha1, 0.7);
    EXPECT_EQ(e.config.threads, 1);
  }
  EXPECT_EQ(read_entries(kDefaultFilters, {}).size(), kPoseFilterNames.size());
}

TEST(CompareEntries, WrongListsAreNamed) {
  for (const auto& [list, part] : {std::pair{"ekf,kalman", "expected one of mcl amcl ekf"},
                                   {"", "expected one of"},
                                   {"ekf,", "expected one of"},
                                   {"edh@", "something after '@'"},
                                   {"edh=", "something after '='"},
                                   {"edh@ten", "whole number"},
                                   {"edh@0", "particles"},
                                   {"ekf@5", "takes no number"},
                                   {"amcl@5", "takes no number"},
                                   {"edh@5,edh@5", "twice"}})
    expect_parts(error_of([&l = list] { read_entries(l, {}); }, ErrorKind::usage), {part});
  error_of([] { read_entries("edh=missing.yaml", {}); }, ErrorKind::config);
}

// ---- logs -------------------------------------------------------------------------------------------------
// The odometry must notice nothing: its steps before and after are the true ones, the one in between is none.
TEST(CompareDrives, AKidnappedRobotIsElsewhereAndItsOdometryIsNot) {
  const TrialLog before = small_log(80);
  TrialLog log = before;
  kidnap(log, 2.0, 1.0);
  const auto gone = before.records.size() - log.records.size();
  ASSERT_GT(gone, 10u);
  std::size_t at = 0;
  while (log.records[at + 1].stamp_s < log.kidnapped_s) ++at;
  EXPECT_NEAR(log.records[at].stamp_s - log.records[0].stamp_s, 2.0, 0.05);
  const auto truth = truth_at(log.truth, {log.records[at].stamp_s, log.kidnapped_s});
  const double far_m = distance_m(*truth[1], *truth[0]);
  EXPECT_GE(far_m, 1.0);
  EXPECT_LT(far_m, 1.0 + 0.05);  // one step of the drive is 3 cm
  const auto step = [](const TrialLog& l, std::size_t k) {
    return relative(l.records[k + 1].odometry, l.records[k].odometry);
  };
  EXPECT_EQ(step(log, at).x_m, 0.0);
  for (std::size_t k = at + 1; k + 1 < log.records.size(); ++k) {
    expect_near(step(log, k), step(before, k + gone), 1e-12, 1e-12);
  }
  error_of([&] { kidnap(log, 0.0, 50.0); }, ErrorKind::input);
  error_of([&] { kidnap(log, 500.0, 1.0); }, ErrorKind::input);
}

TEST(CompareDrives, TheMomentOfAKidnappingGoesWithTheSeed) {
  EXPECT_EQ(kidnapped_after_s({60.0, 60.0, 2.0}, 7), 60.0);
  const Kidnapping spread{60.0, 180.0, 2.0};
  std::vector<double> moments;
  for (std::uint64_t seed = 21; seed <= 40; ++seed) moments.push_back(kidnapped_after_s(spread, seed));
  std::sort(moments.begin(), moments.end());
  EXPECT_GE(moments.front(), 60.0);
  EXPECT_LT(moments.back(), 180.0);
  // Twenty in 120 s: 6 s apart in the mean, and never twice that.
  for (std::size_t k = 1; k < moments.size(); ++k) EXPECT_LT(moments[k] - moments[k - 1], 12.0);
}

// ---- one run ----------------------------------------------------------------------------------------------
TEST(CompareFollow, TheToldStartIsAsWrongAsAsked) {
  const Pose truth{1.0, 2.0, 3.0};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Pose told = told_start({0.1, 0.05, 0.7, 0.3}, truth, seed);
    EXPECT_NEAR(std::hypot(told.x_m - truth.x_m, told.y_m - truth.y_m), 0.7, 1e-12);
    EXPECT_NEAR(wrap64(told.theta_rad - truth.theta_rad), seed % 2 == 1 ? 0.3 : -0.3, 1e-12);
  }
  EXPECT_EQ(told_start({}, truth, 3).x_m, truth.x_m);
}

TEST(CompareFollow, ARunIsJudgedAgainstTheTruth) {
  const GridMap room = test::small_room();
  const TrialLog log = small_log(60);
  for (const Entry& e : read_entries("mcl@500,ekf_beams,edh@50", {})) {
    const auto filter = make_pose_filter(e.kind, e.config, room);
    const auto run = follow(*filter, log, {}, 5);
    ASSERT_TRUE(run);
    EXPECT_EQ(run->seed, 5u);
    EXPECT_EQ(run->scans, 60u);
    EXPECT_EQ(run->errors.compared, 60u);
    EXPECT_EQ(run->step_s.size() + run->skipped, 59u);  // all but the first
    EXPECT_NEAR(run->driven_s, 5.9, 1e-9);
    EXPECT_LT(run->errors.position_rmse_m, 0.1);  // a cell of the map
    EXPECT_FALSE(run->lost());
    EXPECT_EQ(run->found_s, 0.0);
    EXPECT_FALSE(run->lost_s);
    EXPECT_EQ(run->away, 0.0);
    EXPECT_TRUE(std::isfinite(run->nees));
    // The same seed, the same run.
    EXPECT_EQ(follow(*filter, log, {}, 5)->errors.position_error_m, run->errors.position_error_m);
    int scans = 0;
    EXPECT_FALSE(follow(*filter, log, {}, 5, [&] { return ++scans < 3; }));
    EXPECT_EQ(scans, 3);
  }
}

// Told a start two metres off with no doubt about it, a filter that only tracks stays lost.
TEST(CompareFollow, ALostRunIsCalledLost) {
  const Entry e = read_entries("edh@50", {})[0];
  const auto filter = make_pose_filter(e.kind, e.config, test::small_room());
  const auto run = follow(*filter, small_log(60), {0.01, 0.01, 2.0, 0.0}, 3);
  EXPECT_TRUE(run->lost());
  EXPECT_FALSE(run->found_s);
  EXPECT_EQ(run->lost_s, 0.0);
  EXPECT_EQ(run->away, 1.0);
}

// Carried off by a metre after two of its six seconds: lost from there on, and not before.
TEST(CompareFollow, ARunIsLostWhenItIsLost) {
  TrialLog log = small_log(60);
  kidnap(log, 2.0, 1.0);
  const Entry e = read_entries("mcl@500", {})[0];
  const auto run = follow(*make_pose_filter(e.kind, e.config, test::small_room()), log, {}, 3);
  ASSERT_TRUE(run->lost());
  EXPECT_NEAR(*run->lost_s, log.kidnapped_s - log.records[0].stamp_s, 1e-9);
  const auto gone = std::count_if(run->errors.stamp_s.begin(), run->errors.stamp_s.end(),
                                  [&](double stamp_s) { return stamp_s >= log.kidnapped_s; });
  EXPECT_NEAR(run->away, static_cast<double>(gone) / static_cast<double>(run->scans), 1e-9);
}

// ---- several threads --------------------------------------------------------------------------------------
TEST(RunItems, EveryItemIsDoneOnceByAWorkerOfItsThread) {
  std::vector<int> done(100, 0), by(100, -1);
  run_items({100, 3, {}, {}}, [&](std::size_t thread, const KeepGoing&) -> Worker {
    return [&, thread](std::size_t k) { ++done[k], by[k] = static_cast<int>(thread); };
  });
  EXPECT_EQ(std::count(done.begin(), done.end(), 1), 100);
  EXPECT_TRUE(std::all_of(by.begin(), by.end(), [](int thread) { return thread >= 0 && thread < 3; }));
}

TEST(RunItems, AnErrorOrAStopEndsTheWork) {
  std::atomic<int> done = 0;
  const auto failing = [&](std::size_t, const KeepGoing&) -> Worker {
    return [&](std::size_t k) {
      ++done;
      if (k == 3) throw Error(ErrorKind::input, "the fourth");
    };
  };
  EXPECT_EQ(error_of([&] { run_items({1000, 1, {}, {}}, failing); }, ErrorKind::input), "the fourth");
  EXPECT_EQ(done, 4);
  // The other thread waits for what the error of this one brings about.
  const auto waiting = [](std::size_t, const KeepGoing& keep_going) -> Worker {
    return [&](std::size_t k) {
      if (k == 0) throw Error(ErrorKind::input, "the first");
      while (keep_going()) std::this_thread::yield();
    };
  };
  EXPECT_EQ(error_of([&] { run_items({2, 2, {}, {}}, waiting); }, ErrorKind::input), "the first");
  bool told = false;
  run_items({1, 1, [] { return true; }, [&] { told = true; }},
            [](std::size_t, const KeepGoing& keep_going) -> Worker {
              return [&](std::size_t) {
                while (keep_going()) std::this_thread::yield();
              };
            });
  EXPECT_TRUE(told);
}

// ---- many runs --------------------------------------------------------------------------------------------
TEST(CompareSummary, MeansAndDeviations) {
  const MeanDeviation v = mean_deviation({1.0, 2.0, 4.0, 5.0});
  EXPECT_DOUBLE_EQ(v.mean, 3.0);
  EXPECT_DOUBLE_EQ(v.deviation, std::sqrt(10.0 / 3.0));
  EXPECT_TRUE(std::isnan(mean_deviation({1.0}).deviation));
  EXPECT_TRUE(std::isnan(mean_deviation({}).mean));
  FilterRun good, bad;
  good.errors.position_rmse_m = 0.1, good.final_m = 0.1, good.driven_s = 10.0, good.working_s = 1.0;
  bad.errors.position_rmse_m = 0.5, bad.final_m = std::nan(""), bad.driven_s = 10.0, bad.working_s = 3.0;
  good.nees = 3.0, bad.nees = 1e9, good.away = 0.25, bad.away = 0.75, bad.lost_s = 4.0;
  const Summary s = summarise({good, bad});
  EXPECT_EQ(s.runs, 2u);
  EXPECT_EQ(s.lost, 1u);                          // not a number is not at home
  EXPECT_DOUBLE_EQ(s.position_rmse_m.mean, 0.1);  // of the good one alone
  EXPECT_DOUBLE_EQ(s.nees.mean, 3.0);
  EXPECT_DOUBLE_EQ(s.lost_s.mean, 4.0);
  EXPECT_DOUBLE_EQ(s.away, 0.5);
  EXPECT_DOUBLE_EQ(s.real_time_factor, 5.0);
  const Summary none = summarise({bad, bad});
  EXPECT_TRUE(std::isnan(none.position_rmse_m.mean));
  EXPECT_TRUE(std::isnan(none.nees.mean));
}

TEST(ComparePublished, RowsAreFoundWhereTheSettingIsTheirs) {
  const PublishedSetting* s = find_published(1e-4, 0.01, 0.05);
  ASSERT_NE(s, nullptr);
  EXPECT_EQ(find_row(*s, "edh", 100)->position_rmse_m, 0.0437);
  EXPECT_EQ(find_row(*s, "edh", 100)->heading_rmse_rad, 0.0206);
  EXPECT_EQ(find_row(*s, "amcl", 2000)->position_mae_m, 0.0672);
  EXPECT_EQ(find_row(*s, "edh", 50), nullptr);
  EXPECT_EQ(find_row(*s, "gromov", 100), nullptr);
  EXPECT_EQ(find_row(*find_published(5e-4, 0.02, 0.01), "naedh", 100)->step_ms, 49.62);
  EXPECT_EQ(find_published(2e-4, 0.01, 0.05), nullptr);
  EXPECT_EQ(find_published(1e-4, 0.01, 0.01), nullptr);
  EXPECT_EQ(published_settings().size(), 4u);
}

// ---- the settings that ship -------------------------------------------------------------------------------
// For wheels of kappa, the motion model's variances of one scan's motion are those of the wheels (SPEC 1.6).
TEST(CompareConfigs, MotionNoiseIsThatOfTheWheels) {
  constexpr double base_m = 0.16, step_m = 0.18 / 5.0, turn_rad = 0.6 / 5.0;
  for (const auto& [name, kappa_m] :
       {std::pair{"1e-6", 1e-6}, {"1e-4", 1e-4}, {"5e-4", 5e-4}, {"5e-3", 5e-3}}) {
    const Config c = read_entries("ekf=" + kRoot + "configs/compare/kappa_" + name + ".yaml", {})[0].config;
    const MotionStep drive = motion_step(OdometryIncrement{0.0, step_m, 0.0}, c.motion);
    const double heading_rad = std::hypot(drive.sigma_rot1, drive.sigma_rot2);
    EXPECT_NEAR(heading_rad / (std::sqrt(2.0 * kappa_m * step_m) / base_m), 1.0,
                1e-3);  // files have 4 digits
    EXPECT_NEAR(static_cast<double>(drive.sigma_trans) / std::sqrt(kappa_m * step_m / 2.0), 1.0, 1e-3);
    const MotionStep turn = motion_step(OdometryIncrement{0.0, 0.0, turn_rad}, c.motion);
    const double arc_m = base_m * turn_rad / 2.0;
    EXPECT_NEAR(static_cast<double>(turn.sigma_rot2) / (std::sqrt(2.0 * kappa_m * arc_m) / base_m), 1.0,
                1e-3);
    EXPECT_NEAR(static_cast<double>(turn.sigma_trans) / std::sqrt(kappa_m * arc_m / 2.0), 1.0, 1e-3);
  }
}

TEST(CompareConfigs, AllAreSound) {
  const std::string folder = kRoot + "configs/compare/";
  const auto entries =
      read_entries("amcl=" + folder + "turtlebot3.yaml,edh@100=" + kRoot + "configs/csuzdi2021.yaml", {});
  EXPECT_EQ(entries[0].config.max_particles, 3000);
  EXPECT_EQ(entries[0].config.update_min_d, 0.2);
  EXPECT_EQ(entries[1].label, "edh:csuzdi2021@100");
}

}  // namespace
}  // namespace parloc::tools::compare
