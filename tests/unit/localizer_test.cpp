// The closed loop on small simulated maps: start anywhere, track, be kidnapped, and say so when in doubt.
#include "common/localize/localizer.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/math/portable64.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/localize_scenes.h"

namespace parloc {
namespace {

using test::drive;
using test::feed;
using test::small_localizer;

double error_m(const LocalizerEstimate& said, const Pose& truth) {
  return distance_m(said.filter.pose, truth);
}
bool near(const Pose& a, const Pose& b) {
  return distance_m(a, b) < 0.5 && turn_rad(a, b) < 0.17;
}
std::vector<LocalizerEstimate> run_anywhere(const LocalizerConfig& config, const GridMap& map,
                                            const TrialLog& log, const SearchPrior& prior = {}) {
  Localizer localizer(config, map);
  localizer.start_anywhere(prior);
  return feed(localizer, log.records);
}

TEST(Localizer, FindsItselfAndTracks) {
  const GridMap map = test::two_rooms();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const TrialLog log = drive(map, TrialTask::global, 6.0, seed);
    const auto said = run_anywhere(small_localizer(), map, log);
    ASSERT_EQ(said.size(), log.truth.size());
    EXPECT_TRUE(said.front().searched);
    EXPECT_EQ(said.back().health.state, HealthState::tracking) << "seed " << seed;
    EXPECT_GT(said.back().health.probability, 0.8);
    EXPECT_LT(error_m(said.back(), log.truth.back().pose), 0.2);  // two cells
    EXPECT_FALSE(said.back().searched);                           // settled: no more of it
  }
}

// Before its first search the localizer does nothing that the bare filter does not: the same bits.
TEST(Localizer, OnlyWatchesWhileItIsNotLost) {
  const GridMap map = test::two_rooms();
  const TrialLog log = drive(map, TrialTask::track, 6.0, 7);
  const LocalizerConfig config = small_localizer();
  Localizer watched(config, map);
  watched.start_at(log.truth.front().pose, 0.2, 0.1, 0.1);
  ParticleFilter bare(config, map);
  bare.start_at(log.truth.front().pose, 0.2, 0.1, 0.1);
  const auto said = feed(watched, log.records);
  std::size_t k = 0;
  for (const LogRecord& r : log.records) {
    bare.add_odometry(r.stamp_s, r.odometry);
    if (r.kind == RecordKind::odometry) continue;
    EXPECT_EQ(bare.step(r.odometry, r.scan).pose.x_m, said[k++].filter.pose.x_m);
  }
  EXPECT_EQ(watched.filter().digest(), bare.digest());
  EXPECT_EQ(watched.searches(), 0u);
  for (const LocalizerEstimate& e : said) EXPECT_EQ(e.health.state, HealthState::tracking);
}

TEST(Localizer, NoticesAKidnappingAndFindsItselfAgain) {
  const GridMap map = test::two_rooms();
  const TrialLog log = drive(map, TrialTask::kidnap, 6.0, 2);
  for (const bool recover : {true, false}) {
    LocalizerConfig config = small_localizer();
    config.localize.recover = recover;
    config.localize.slips = recover;  // the rooms are small: what it was carried by might be found near by
    Localizer localizer(config, map);
    localizer.start_at(log.truth.front().pose, 0.1, 0.1, 0.05);
    const auto said = feed(localizer, log.records);
    bool noticed = false;
    for (std::size_t k = 0; k < said.size(); ++k) {
      const double since_s = log.truth[k].stamp_s - log.kidnapped_s;
      if (since_s < 0.0) {
        EXPECT_EQ(said[k].health.state, HealthState::tracking);
      }
      noticed = noticed || (since_s >= 0.0 && since_s < 2.0 && said[k].health.state == HealthState::lost);
    }
    EXPECT_TRUE(noticed);
    if (recover) {
      EXPECT_EQ(said.back().health.state, HealthState::tracking);
      EXPECT_LT(error_m(said.back(), log.truth.back().pose), 0.2);
      EXPECT_GE(localizer.searches(), 1u);
    } else {
      EXPECT_EQ(localizer.searches(), 0u);
      EXPECT_GT(error_m(said.back(), log.truth.back().pose), 0.5);
      EXPECT_EQ(said.back().health.state, HealthState::lost);
    }
  }
}

TEST(Localizer, WithoutRecoveryAStartAnywhereIsSearchedOnce) {
  const GridMap map = test::two_rooms();
  const TrialLog log = drive(map, TrialTask::global, 4.0, 3);
  LocalizerConfig config = small_localizer();
  config.localize.recover = false;
  const auto said = run_anywhere(config, map, log);
  for (std::size_t k = 0; k < said.size(); ++k) EXPECT_EQ(said[k].searched, k == 0) << k;
  EXPECT_EQ(said.back().health.state, HealthState::tracking);
}

TEST(Localizer, ASymmetricRoomStaysAmbiguousWithBothPoses) {
  const GridMap room = test::bare_room();
  const TrialLog log = drive(room, TrialTask::global, 6.0, 4);
  const auto said = run_anywhere(small_localizer(), room, log);
  for (const LocalizerEstimate& e : said) EXPECT_NE(e.health.state, HealthState::tracking);
  const Pose truth = log.truth.back().pose;
  const Pose mirrored{8.0 - truth.x_m, 5.0 - truth.y_m, wrap64(truth.theta_rad + M_PI)};
  const LocalizerEstimate& last = said.back();
  EXPECT_EQ(last.health.state, HealthState::ambiguous);
  bool has_truth = false, has_mirrored = false;
  for (const Mode& mode : last.modes) {
    has_truth = has_truth || near(mode.pose, truth);
    has_mirrored = has_mirrored || near(mode.pose, mirrored);
  }
  EXPECT_TRUE(has_truth && has_mirrored) << last.modes.size() << " modes";

  // A compass decides.
  SearchPrior prior;
  prior.heading = {{log.truth.front().pose.theta_rad, 0.5}};
  const auto known = run_anywhere(small_localizer(), room, log, prior);
  EXPECT_LT(error_m(known.front(), log.truth.front().pose), 0.3);
}

TEST(Localizer, OneOfSeveralCandidatesWins) {
  const GridMap map = test::two_rooms();
  const TrialLog log = drive(map, TrialTask::track, 5.0, 6);
  Localizer localizer(small_localizer(), map);
  const Pose truth = log.truth.front().pose;
  localizer.start_at({{{truth.x_m < 7 ? 11.0 : 3.0, 3.0, 1.0}, 0.2, 0.1, 1.0}, {truth, 0.2, 0.1, 1.0}});
  const auto said = feed(localizer, log.records);
  EXPECT_EQ(said.back().health.state, HealthState::tracking);
  EXPECT_LT(error_m(said.back(), log.truth.back().pose), 0.2);
}

/// Everything that it says and the filter's digest, over a global start and a kidnapping.
std::string all_bits(const TrialLog& log, const GridMap& map, int threads) {
  Localizer localizer(small_localizer(threads), map);
  localizer.start_anywhere();
  std::string text;
  for (const LocalizerEstimate& e : feed(localizer, log.records)) {
    text.append(reinterpret_cast<const char*>(&e.health.probability), sizeof(double));
    text.append(reinterpret_cast<const char*>(&e.filter.pose), sizeof(Pose));
    text += std::to_string(e.modes.size()) + (e.searched ? "s" : "-") + std::to_string(e.found);
  }
  return text + localizer.filter().digest();
}

TEST(Localizer, TheSameBitsWithAnyThreadsAndInstructionSet) {
  const GridMap map = test::two_rooms();
  const TrialLog log = drive(map, TrialTask::kidnap, 2.4, 8);
  const std::string expected = all_bits(log, map, 1);
  EXPECT_EQ(all_bits(log, map, 2), expected);
  for (const cpu::Simd most : {cpu::Simd::baseline, cpu::Simd::avx2}) {
    const test::SimdLimit limit(most);
    EXPECT_TRUE(all_bits(log, map, 2) == expected) << cpu::simd_name(most);
  }
}

TEST(Localizer, ScansWithoutBeamsAreNoPlace) {
  const GridMap map = test::two_rooms();
  TrialLog log = drive(map, TrialTask::global, 2.0, 1);
  TrialLog blind = log;
  for (LogRecord& r : blind.records) r.scan.ranges_m.clear();
  for (const LocalizerEstimate& e : run_anywhere(small_localizer(), map, blind)) {
    EXPECT_EQ(e.health.state, HealthState::lost);
    EXPECT_EQ(e.found, 0u);
  }
  // Blind at first, it starts when it sees; also where it would not search again.
  const std::size_t until = log.records.size() / 2;
  for (std::size_t k = 0; k < until; ++k) log.records[k].scan.ranges_m.clear();
  LocalizerConfig config = small_localizer();
  config.localize.recover = false;
  const auto said = run_anywhere(config, map, log);
  EXPECT_LT(error_m(said.back(), log.truth.back().pose), 0.3);
}

// Something stands around the robot for a moment: when it sees the walls again it is where it was, without a
// search and without a doubt.
TEST(Localizer, SomeBadScansPassByThemselves) {
  const GridMap map = test::two_rooms();
  TrialLog log = drive(map, TrialTask::track, 6.0, 7);
  std::size_t scans = 0;
  for (LogRecord& r : log.records) {
    if (r.kind != RecordKind::scan) continue;
    if (++scans > 10 && scans <= 14)
      for (std::size_t k = 0; k < r.scan.ranges_m.size(); ++k)
        r.scan.ranges_m[k] = k % 2 == 0 ? 5.9f : 4.5f;  // through most walls
  }
  Localizer localizer(small_localizer(), map);
  localizer.start_at(log.truth.front().pose, 0.1, 0.1, 0.05);
  const auto said = feed(localizer, log.records);
  EXPECT_EQ(localizer.searches(), 0u);
  for (std::size_t k = 17; k < said.size(); ++k) {
    EXPECT_EQ(said[k].health.state, HealthState::tracking) << "scan " << k;
    EXPECT_LT(error_m(said[k], log.truth[k].pose), 0.3);
  }
}

// The wheels say nothing of a turn by 15 degrees, or of 0.3 m: the scan that comes next says it.
TEST(Localizer, AHiddenMotionIsFoundByTheNextScan) {
  const GridMap map = test::two_rooms();
  for (const Pose& hidden : {Pose{0.0, 0.0, 0.26}, Pose{0.0, 0.0, -0.26}, Pose{0.3, 0.0, 0.0}})
    for (const std::uint64_t seed : {7u, 9u}) {
      const TrialLog log = drive(map, TrialTask::track, 6.0, seed);
      std::vector<LogRecord> records = log.records;
      const std::size_t from = records.size() / 2;
      const Pose there = records[from].odometry, said_there = compose(there, inverse(hidden));
      for (std::size_t k = from; k < records.size(); ++k)
        records[k].odometry = compose(said_there, relative(records[k].odometry, there));
      Localizer localizer(small_localizer(), map);
      localizer.start_at(log.truth.front().pose, 0.1, 0.1, 0.05);
      const auto said = feed(localizer, records);
      for (std::size_t k = 0; k < said.size(); ++k) {
        EXPECT_TRUE(near(said[k].filter.pose, log.truth[k].pose)) << "scan " << k << ", seed " << seed;
        EXPECT_NE(said[k].health.state, HealthState::lost);
      }
      EXPECT_LT(error_m(said.back(), log.truth.back().pose), 0.2);
      EXPECT_EQ(localizer.searches(), 0u);  // of the whole map
    }
}

TEST(Localizer, OneReadingOfAnySizeIsPassedOver) {
  const GridMap map = test::two_rooms();
  const TrialLog log = drive(map, TrialTask::track, 6.0, 7);
  for (const double far_m : {10.0, 1e3, 1e6, 1e200}) {
    std::vector<LogRecord> records = log.records;
    records[records.size() / 3].odometry.x_m += far_m;
    records[records.size() / 2].odometry.y_m -= far_m;
    Localizer localizer(small_localizer(), map);
    localizer.start_at(log.truth.front().pose, 0.1, 0.1, 0.05);
    const auto said = feed(localizer, records);
    for (std::size_t k = 0; k < said.size(); ++k) {
      EXPECT_LT(error_m(said[k], log.truth[k].pose), 0.3) << far_m << ", scan " << k;
      EXPECT_TRUE(std::isfinite(said[k].health.probability));
      for (const double v : said[k].filter.covariance.v) EXPECT_TRUE(std::isfinite(v));
    }
    EXPECT_EQ(said.back().health.state, HealthState::tracking);
  }
}

// The gyro of a robot that stands drifts by 0.05 degrees a second: the walls stand still.
TEST(Localizer, StandingStillIsNotTurning) {
  const GridMap map = test::two_rooms();
  const TrialLog log = drive(map, TrialTask::track, 1.0, 7);
  LogRecord record = log.records.front();
  Localizer localizer(small_localizer(), map);
  localizer.start_at(log.truth.front().pose, 0.1, 0.1, 0.05);
  for (int k = 0; k < 600; ++k) {
    record.stamp_s += 0.1, record.scan.stamp_s += 0.1;
    record.odometry.theta_rad += 0.005 * M_PI / 180.0;
    const LocalizerEstimate said = localizer.step(record.odometry, record.scan);
    EXPECT_LT(std::fabs(wrap64(said.filter.pose.theta_rad - log.truth.front().pose.theta_rad)), 0.0175) << k;
    EXPECT_EQ(said.health.state, HealthState::tracking);
  }
}

TEST(Localizer, AMapWithoutWallsHasNoPlace) {
  const GridMap empty = grid_from_text(std::vector<std::string>(90, std::string(140, '.')), 0.1);
  const TrialLog log = drive(test::two_rooms(), TrialTask::global, 1.0, 1);
  for (const LocalizerEstimate& e : run_anywhere(small_localizer(), empty, log))
    EXPECT_NE(e.health.state, HealthState::tracking);
}

TEST(Localizer, OdometryThatIsNotANumberIsPassedOver) {
  const GridMap map = test::two_rooms();
  TrialLog log = drive(map, TrialTask::global, 5.0, 2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < log.records.size(); k += 8) log.records[k].odometry.x_m = nan;
  const auto said = run_anywhere(small_localizer(), map, log);
  EXPECT_EQ(said.front().health.state, HealthState::lost);  // the first is such a one
  EXPECT_FALSE(said.front().searched);
  for (const LocalizerEstimate& e : said) EXPECT_TRUE(std::isfinite(e.filter.pose.x_m));
  EXPECT_EQ(said.back().health.state, HealthState::tracking);
}

}  // namespace
}  // namespace parloc
