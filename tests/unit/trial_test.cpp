// Judging a trial and putting many together, on samples made by hand; a trial run on a small drive.
#include <gtest/gtest.h>

#include <limits>

#include "common/error.h"
#include "common/eval/run_trial.h"
#include "common/eval/trial_summary.h"
#include "common/map/map_reader.h"
#include "tests/unit/small_drive.h"

namespace parloc {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr auto kTracking = HealthState::tracking, kAmbiguous = HealthState::ambiguous,
               kLost = HealthState::lost;

TrialPlan plan_of(TrialTask task) {
  TrialPlan plan;
  plan.task = task;
  plan.hold_s = 2.0;
  return plan;
}

/// Ten samples a second from stamp 100 s on.
class Samples {
 public:
  Samples& add(double seconds, double error_m, HealthState state, double probability = 0.9) {
    for (int k = 0; k < std::lround(10.0 * seconds); ++k) {
      TrialSample s;
      s.stamp_s = 100.0 + 0.1 * static_cast<double>(samples_.size());
      s.position_error_m = error_m;
      s.heading_error_rad = 0.01;
      s.state = state;
      s.probability = probability;
      s.nees = 3.0;
      samples_.push_back(s);
    }
    return *this;
  }
  Samples& without_covariance(std::size_t k) {
    samples_[k].nees = kNan;
    return *this;
  }
  const std::vector<TrialSample>& list() const { return samples_; }

 private:
  std::vector<TrialSample> samples_;
};

/// Of a kidnapping after 3 s; else from the first sample on.
TrialOutcome judged(TrialTask task, const Samples& samples) {
  return judge_trial(plan_of(task), samples.list(), task == TrialTask::kidnap ? 103.0 : 100.0);
}

TEST(JudgeTrial, RightAllTheTime) {
  const TrialOutcome o = judged(TrialTask::global, Samples().add(5, 0.1, kTracking));
  ASSERT_TRUE(o.localized_after_s);
  EXPECT_EQ(*o.localized_after_s, 0.0);
  EXPECT_EQ(o.right, 50u);
  EXPECT_EQ(o.confident_wrong, 0u);
  EXPECT_EQ(o.false_lost, 0u);
  EXPECT_EQ(o.wrong_since, 0u);
  EXPECT_NEAR(o.right_s, 4.9, 1e-9);  // the last sample has no time after it
  EXPECT_EQ(o.wrong_s, 0.0);
  EXPECT_NEAR(o.squared_error_m2, 50 * 0.01, 1e-9);
  EXPECT_NEAR(o.nees_sum, 150.0, 1e-9);
  EXPECT_EQ(o.nees_count, 50u);
}

TEST(JudgeTrial, WrongAndSureOfIt) {
  const TrialOutcome o =
      judged(TrialTask::global, Samples().add(1, 4.0, kAmbiguous).add(2, 4.0, kTracking).add(1, 4.0, kLost));
  EXPECT_FALSE(o.localized_after_s);
  EXPECT_EQ(o.right, 0u);
  EXPECT_EQ(o.confident_wrong, 20u);
  EXPECT_NEAR(o.confident_wrong_s, 1.9, 1e-9);
  EXPECT_NEAR(o.wrong_s, 3.9, 1e-9);
  EXPECT_NEAR(o.missed_lost_s, 2.0, 1e-9);
  EXPECT_EQ(o.since_localized, 0u);
}

TEST(JudgeTrial, AHeadingThatIsOffOrNoNumberAtAllIsWrong) {
  const TrialPlan plan = plan_of(TrialTask::global);
  TrialSample s;
  s.position_error_m = 0.1;
  s.heading_error_rad = 0.3;
  EXPECT_FALSE(is_right(plan, s));
  s.heading_error_rad = kNan;
  EXPECT_FALSE(is_right(plan, s));
  s.heading_error_rad = 0.1;
  EXPECT_TRUE(is_right(plan, s));
  s.position_error_m = kNan;
  EXPECT_FALSE(is_right(plan, s));
}

// Right for 1 s by chance, wrong, then right for good: only the last counts, and what was before is no error
// of tracking.
TEST(JudgeTrial, MustHold) {
  const TrialOutcome o = judged(
      TrialTask::global, Samples().add(1, 0.1, kAmbiguous).add(1, 5.0, kAmbiguous).add(3, 0.2, kTracking));
  ASSERT_TRUE(o.localized_after_s);
  EXPECT_NEAR(*o.localized_after_s, 2.0, 1e-9);
  EXPECT_EQ(o.since_localized, 30u);
  EXPECT_NEAR(o.squared_error_m2, 30 * 0.04, 1e-9);
}

TEST(JudgeTrial, WrongAgainAfterItHeld) {
  const TrialOutcome o = judged(TrialTask::global, Samples().add(3, 0.1, kTracking).add(1, 5.0, kLost));
  EXPECT_EQ(*o.localized_after_s, 0.0);
  EXPECT_EQ(o.wrong_since, 10u);
  EXPECT_EQ(o.since_localized, 40u);
}

TEST(JudgeTrial, FlickerToLostIsCountedByTurns) {
  Samples s;
  s.add(1, 0.1, kTracking);
  for (const double lost_s : {0.3, 0.1}) s.add(lost_s, 0.1, kLost).add(1, 0.1, kTracking);
  EXPECT_EQ(judged(TrialTask::track, s).false_lost, 2u);
}

// Before the first scan of a global start nobody can know; told the start, it can.
TEST(JudgeTrial, LostAtTheVeryFirstIsFalseOnlyIfTheStartWasGiven) {
  const Samples s = Samples().add(0.1, 0.1, kLost).add(1, 0.1, kTracking);
  EXPECT_EQ(judged(TrialTask::global, s).false_lost, 0u);
  EXPECT_EQ(judged(TrialTask::track, s).false_lost, 1u);
}

TEST(JudgeTrial, LostWhileWrongIsNotFalse) {
  Samples s;
  s.add(1, 0.1, kTracking).add(1, 3.0, kLost).add(1, 0.1, kLost).add(1, 0.1, kTracking);
  EXPECT_EQ(judged(TrialTask::track, s).false_lost, 0u);
}

TEST(JudgeTrial, AKidnappingHasAGraceAndIsNoticed) {
  Samples s;
  s.add(3, 0.1, kTracking).add(1.5, 8.0, kTracking).add(1, 8.0, kLost).add(3, 0.1, kTracking);
  const TrialOutcome o = judged(TrialTask::kidnap, s);  // with 2 s of grace
  EXPECT_TRUE(o.tracked_before);
  EXPECT_EQ(o.confident_wrong, 0u);
  EXPECT_NEAR(o.missed_lost_s, 1.5, 1e-9);
  ASSERT_TRUE(o.noticed_after_s);
  EXPECT_NEAR(*o.noticed_after_s, 1.5, 1e-9);
  EXPECT_NEAR(*o.localized_after_s, 2.5, 1e-9);  // since the kidnapping
  // The same without a kidnapping is wrong and sure.
  EXPECT_EQ(judged(TrialTask::track, s).confident_wrong, 15u);
}

TEST(JudgeTrial, AfterTheGraceAKidnappedRobotMustKnow) {
  const TrialOutcome o =
      judged(TrialTask::kidnap, Samples().add(3, 0.1, kTracking).add(3.5, 8.0, kTracking).add(1, 8.0, kLost));
  EXPECT_EQ(o.confident_wrong, 15u);
  EXPECT_NEAR(o.confident_wrong_s, 1.4, 1e-9);
  EXPECT_NEAR(*o.noticed_after_s, 3.5, 1e-9);
  EXPECT_FALSE(o.localized_after_s);
}

TEST(JudgeTrial, WhoIsLostAlreadyHasNothingToNotice) {
  const Samples s = Samples().add(2, 0.1, kTracking).add(1, 0.1, kAmbiguous).add(3, 8.0, kLost);
  EXPECT_FALSE(judged(TrialTask::kidnap, s).tracked_before);
}

TEST(JudgeTrial, ACovarianceThatIsNoneDoesNotSpoilTheRest) {
  const TrialOutcome o = judged(TrialTask::track, Samples().add(3, 0.1, kTracking).without_covariance(4));
  EXPECT_EQ(o.nees_count, 29u);
  EXPECT_NEAR(o.nees_sum, 87.0, 1e-9);
}

TEST(Spread, MedianRankAndMost) {
  const Spread none = spread_of({});
  EXPECT_EQ(none.count, 0u);
  EXPECT_TRUE(std::isnan(none.median));
  EXPECT_EQ(spread_of({7.0}).p95, 7.0);
  std::vector<double> values;
  for (int k = 100; k >= 1; --k) values.push_back(k);
  const Spread s = spread_of(values);
  EXPECT_EQ(s.median, 50.5);
  EXPECT_EQ(s.p95, 95.0);
  EXPECT_EQ(s.most, 100.0);
}

TEST(MeanInterval, OfKnownValues) {
  const MeanInterval m = mean_interval({1.0, 2.0, 3.0, 4.0});
  EXPECT_EQ(m.mean, 2.5);
  // Standard deviation sqrt(5/3), over sqrt(4).
  EXPECT_NEAR(m.high - m.mean, 1.959964 * std::sqrt(5.0 / 3.0) / 2.0, 1e-6);
  EXPECT_NEAR(m.mean - m.low, m.high - m.mean, 1e-12);
  EXPECT_TRUE(std::isnan(mean_interval({3.0}).low));
}

TrialResult result_of(TrialTask task, std::uint64_t seed, const Samples& samples) {
  TrialResult r;
  r.seed = seed;
  r.samples = samples.list();
  r.marks = marks_of(plan_of(task), r.samples);
  r.outcome = judged(task, samples);
  return r;
}

TEST(Summarise, CountsTrials) {
  const std::vector<TrialResult> trials{
      result_of(TrialTask::global, 1, Samples().add(10, 0.1, kTracking, 0.9)),
      result_of(TrialTask::global, 2, Samples().add(5, 3.0, kLost, 0.1).add(5, 0.3, kTracking, 0.9)),
      result_of(TrialTask::global, 3, Samples().add(10, 3.0, kTracking, 0.8))};
  const TrialSummary s = summarise(plan_of(TrialTask::global), 3.0, trials);
  EXPECT_EQ(s.trials, 3u);
  EXPECT_EQ(s.success.hits, 1u);
  EXPECT_EQ(s.localized.hits, 2u);
  EXPECT_EQ(s.right_after.hits, 2u);
  EXPECT_EQ(s.right_after.trials, 2u);
  EXPECT_EQ(s.localize_s.count, 2u);
  EXPECT_NEAR(s.localize_s.most, 5.0, 1e-9);
  EXPECT_EQ(s.confident_wrong.hits, 1u);
  EXPECT_EQ(s.confident_wrong_1s.hits, 1u);
  EXPECT_NEAR(s.right_s, 9.9 + 4.9, 1e-9);
  EXPECT_NEAR(s.wrong_s, 5.0 + 9.9, 1e-9);
  EXPECT_NEAR(s.missed_lost, 9.9 / 14.9, 1e-9);
  EXPECT_EQ(s.false_lost_per_hour, 0.0);
  EXPECT_NEAR(s.rmse_m, std::sqrt((100 * 0.01 + 50 * 0.09) / 150), 1e-9);
  EXPECT_EQ(s.nees.count, 2u);
  EXPECT_NEAR(s.nees.mean, 3.0, 1e-9);
  EXPECT_EQ(s.calibration.count, 300u);
  EXPECT_NEAR(s.calibration.brier, (150 * 0.01 + 50 * 0.01 + 100 * 0.64) / 300, 3e-5);
  EXPECT_EQ(s.failed, (std::vector<std::uint64_t>{2, 3}));
}

TEST(Summarise, FalseLostPerHourOfDrivingWhileRight) {
  Samples s;
  s.add(18, 0.1, kTracking).add(1, 0.1, kLost).add(17.1, 0.1, kTracking);  // 36 s
  const TrialSummary t =
      summarise(plan_of(TrialTask::track), 3.0, std::vector{result_of(TrialTask::track, 1, s)});
  EXPECT_NEAR(t.false_lost_per_hour, 100.0, 1e-6);
}

TEST(Summarise, OnlyAKidnappingIsNoticed) {
  Samples s;
  s.add(3, 0.1, kTracking).add(1, 8.0, kTracking).add(1, 8.0, kLost).add(3, 0.1, kTracking);
  const TrialSummary k =
      summarise(plan_of(TrialTask::kidnap), 5.0, std::vector{result_of(TrialTask::kidnap, 1, s)});
  EXPECT_EQ(k.noticed.hits, 1u);
  EXPECT_NEAR(k.notice_s.median, 1.0, 1e-9);
  const TrialSummary t =
      summarise(plan_of(TrialTask::track), 3.0, std::vector{result_of(TrialTask::track, 1, s)});
  EXPECT_EQ(t.notice_s.count, 0u);
}

TEST(Summarise, OfNothingIsNoNumber) {
  const TrialSummary s = summarise(plan_of(TrialTask::global), 3.0, ResultStream<TrialResult>());
  EXPECT_EQ(s.trials, 0u);
  EXPECT_TRUE(std::isnan(s.success.share));
  EXPECT_TRUE(std::isnan(s.rmse_m));
  EXPECT_TRUE(std::isnan(s.false_lost_per_hour));
  EXPECT_TRUE(s.failed.empty());
}

/// The share of clutter in a trial of a scenario whose own path is so long.
double unmapped_share(double path_m) {
  const GridMap map = read_map("maps/office.yaml");
  Scenario scenario;
  scenario.path.points = {{0.0, 0.0, 0.0, 0.0}, {path_m, 0.0, 0.0, 0.0}};
  scenario.clutter.boxes = 60;
  TrialPlan plan;
  plan.duration_s = 10.0;
  double hits = 0.0, unmapped = 0.0;
  const WanderArea area(map, 0.3);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const TrialLog log = simulate_trial(plan, scenario, map, area, seed);
    hits += static_cast<double>(log.hits);
    unmapped += static_cast<double>(log.unmapped);
  }
  return unmapped / hits;
}

// 60 boxes along 10 m fill the view; along 1 km hardly one stands beside a drive of a few metres.
TEST(SimulateTrial, BoxesAreAsDenseAsInTheScenario) {
  EXPECT_GT(unmapped_share(10.0), 0.3);
  EXPECT_LT(unmapped_share(1000.0), 0.1);
}

class RunTrial : public testing::Test {
 protected:
  static LocalizerConfig config() {
    LocalizerConfig c;
    c.backend = BackendChoice::cpu;
    c.threads = 1;
    c.particles = 500;
    return c;
  }
  RunTrial() {
    const test::SmallDrive drive = test::small_drive(room, 40);
    log.records = drive.scans;
    log.truth = drive.truth;
  }
  const GridMap room = test::small_room();
  TrialLog log;
  Localizer localizer{config(), room};
};

TEST_F(RunTrial, LocalizesInASmallRoomWhateverItDidBefore) {
  const TrialPlan plan = plan_of(TrialTask::global);
  const auto first = run_trial(localizer, plan, log, 5);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->seed, 5u);
  EXPECT_EQ(first->begun_s, 100.0);
  EXPECT_EQ(first->start.x_m, log.truth[0].pose.x_m);
  EXPECT_EQ(first->samples.size(), 40u);
  EXPECT_GE(first->searches, 1u);
  EXPECT_TRUE(first->samples[0].searched);
  EXPECT_TRUE(first->outcome.localized_after_s) << first->samples.back().position_error_m;
  run_trial(localizer, plan_of(TrialTask::track), log, 6);
  const auto again = run_trial(localizer, plan, log, 5);
  ASSERT_TRUE(again);
  for (std::size_t k = 0; k < 40; ++k) {
    EXPECT_EQ(again->samples[k].position_error_m, first->samples[k].position_error_m);
    EXPECT_EQ(again->samples[k].probability, first->samples[k].probability);
  }
}

TEST_F(RunTrial, ComparesOnlyWhereThereIsATruth) {
  log.truth.erase(log.truth.begin(), log.truth.begin() + 10);
  const auto result = run_trial(localizer, plan_of(TrialTask::global), log, 1);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->samples.size(), 30u);
  EXPECT_EQ(result->begun_s, 100.0);  // its time runs from the first scan, all the same
  EXPECT_THROW(run_trial(localizer, plan_of(TrialTask::track), log, 1), Error);
  log.truth = {{900.0, {}}};
  EXPECT_THROW(run_trial(localizer, plan_of(TrialTask::global), log, 1), Error);
  log.records.clear();
  EXPECT_THROW(run_trial(localizer, plan_of(TrialTask::global), log, 1), Error);
}

TEST_F(RunTrial, StopsWhenAsked) {
  int scans = 0;
  EXPECT_FALSE(run_trial(localizer, plan_of(TrialTask::track), log, 1, [&](double fraction) {
    EXPECT_NEAR(fraction, ++scans / 40.0, 1e-12);
    return scans < 3;
  }));
  EXPECT_EQ(scans, 3);
}

}  // namespace
}  // namespace parloc
