// What a filter is worth: evidence of a scan, health, modes.
#include <gtest/gtest.h>

#include "common/config/config.h"
#include "common/error.h"
#include "common/localize/scan_novelty.h"
#include "common/localize/slip_search.h"
#include "common/math/portable64.h"
#include "common/search/scan_evidence.h"
#include "tests/unit/localize_scenes.h"

namespace parloc {
namespace {

/// The scan of a drive's first moment as the filter takes it.
struct FirstScan {
  explicit FirstScan(const GridMap& map, std::uint64_t seed = 3) {
    const TrialLog log = test::drive(map, TrialTask::track, 1.0, seed);
    truth = log.truth.front().pose;
    const ParticleFilter filter(test::small_localizer(), map);
    beams = filter.beams(log.records.front().scan);
  }
  Pose truth;
  BeamTable beams;
};

TEST(ScanEvidence, IsHighWhereTheRobotIsAndLowElsewhere) {
  const GridMap map = test::two_rooms();
  ScanEvidence evidence(map);
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const FirstScan first(map, seed);
    // The drawing is exact and the noise small: 1 nat is far below what the model's peak gives.
    EXPECT_GT(evidence.per_beam(first.beams, first.truth), 1.0);
    const Pose turned{first.truth.x_m, first.truth.y_m, first.truth.theta_rad + 0.8};
    const Pose elsewhere{first.truth.x_m > 7.0 ? 3.0 : 10.5, 4.5, first.truth.theta_rad};
    for (const Pose& wrong : {turned, elsewhere}) EXPECT_LT(evidence.per_beam(first.beams, wrong), 0.3);
  }
}

// Maps made on a drive have unknown cells where the robot itself stood.
TEST(ScanEvidence, UnknownCellsHideNothing) {
  const GridMap map = test::two_rooms();
  const FirstScan first(map);
  GridMap with_unknown = map;
  const int i = static_cast<int>(first.truth.x_m / map.resolution_m);
  const int j = static_cast<int>(first.truth.y_m / map.resolution_m);
  for (int y = j - 2; y <= j + 2; ++y)
    for (int x = i - 2; x <= i + 2; ++x)
      with_unknown.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                         static_cast<std::size_t>(x)] = Cell::unknown;
  ScanEvidence evidence(with_unknown);
  EXPECT_GT(evidence.per_beam(first.beams, first.truth), 1.0);
}

TEST(ScanEvidence, IsTheSameEveryTime) {
  const GridMap map = test::two_rooms();
  const FirstScan first(map);
  ScanEvidence one(map), other(map);
  const double expected = one.per_beam(first.beams, first.truth);
  BeamTable farther = first.beams;
  farther.range_max_m = 9.0f;
  other.per_beam(farther, first.truth);  // a LiDAR of another reach between changes nothing
  EXPECT_EQ(other.per_beam(first.beams, first.truth), expected);
  EXPECT_EQ(one.per_beam(first.beams, first.truth), expected);
}

// Where nothing is in reach, a scan without returns fits everywhere, so it tells nothing of any place.
TEST(ScanEvidence, AScanThatFitsEverywhereTellsNothing) {
  const GridMap empty = grid_from_text(std::vector<std::string>(100, std::string(100, '.')), 0.1);
  ScanEvidence evidence(empty);
  BeamTable beams = FirstScan(test::two_rooms()).beams;
  beams.hits = 0;                                                     // all of them misses
  EXPECT_NEAR(evidence.per_beam(beams, {5.0, 5.0, 0.0}), 0.0, 1e-5);  // float rounding of the logarithms
  EXPECT_NEAR(evidence.per_beam(beams, {2.0, 7.0, 2.0}), 0.0, 1e-5);
  beams.count = 0;
  EXPECT_EQ(evidence.per_beam(beams, {5.0, 5.0, 0.0}), 0.0);
}

TEST(ScanEvidence, AMapWithoutFreeCellsIsAnError) {
  const GridMap full = grid_from_text(std::vector<std::string>(5, "#####"), 0.1);
  EXPECT_THROW(ScanEvidence{full}, Error);
}

Health feed(HealthMonitor& monitor, double evidence, double share, int times, double novelty = 1.0) {
  Health h;
  for (int k = 0; k < times; ++k) h = monitor.update({evidence, 2.5, share, novelty});
  return h;
}

TEST(HealthMonitor, FollowsTheEvidenceAndDoesNotFlicker) {
  HealthMonitor monitor;
  Health h = feed(monitor, 2.0, 1.0, 1);
  EXPECT_EQ(h.state, HealthState::tracking);  // the first scan counts in full
  EXPECT_GT(h.probability, 0.9);
  h = feed(monitor, -0.5, 1.0, 10);
  EXPECT_EQ(h.state, HealthState::lost);
  EXPECT_LT(h.probability, 0.1);
  EXPECT_NEAR(h.evidence, -0.5, 0.05);
  h = feed(monitor, 2.0, 0.5, 10);
  EXPECT_EQ(h.state, HealthState::ambiguous);
  EXPECT_NEAR(h.probability, 0.5, 0.05);  // half of the weight is elsewhere
  monitor.reset();
  EXPECT_EQ(feed(monitor, 2.0, 1.0, 1).state, HealthState::tracking);
}

// A place that was right for long is not lost for a scan, nor for two; a new one is.
TEST(HealthMonitor, OneBadScanIsNoReasonToDoubtAGoodPlace) {
  HealthMonitor monitor;
  feed(monitor, 2.0, 1.0, 50);
  EXPECT_EQ(feed(monitor, -3.0, 1.0, 1).state, HealthState::tracking);
  EXPECT_EQ(feed(monitor, -3.0, 1.0, 1).state, HealthState::tracking);
  EXPECT_EQ(feed(monitor, -3.0, 1.0, 2).state, HealthState::lost);
  HealthMonitor fresh;
  EXPECT_EQ(feed(fresh, -3.0, 1.0, 1).state, HealthState::lost);
}

// As many scans as a LiDAR makes from one spot: what they say is one thing.
TEST(HealthMonitor, CountsWhatIsNewAndNotHowOften) {
  HealthMonitor slow, fast;
  feed(slow, 2.0, 1.0, 5), feed(fast, 2.0, 1.0, 200, 5.0 / 200);
  const Health one = feed(slow, 0.2, 1.0, 3), other = feed(fast, 0.2, 1.0, 120, 3.0 / 120);
  EXPECT_NEAR(one.probability, other.probability, 1e-3);
}

// Among people, and nowhere else on the map fits it better.
TEST(HealthMonitor, WhatIsAcceptedIsTypical) {
  HealthMonitor monitor;
  feed(monitor, 2.6, 1.0, 200);
  EXPECT_EQ(feed(monitor, 0.9, 1.0, 20).state, HealthState::lost);
  monitor.accept();
  EXPECT_EQ(feed(monitor, 0.9, 1.0, 20).state, HealthState::tracking);
  EXPECT_EQ(feed(monitor, 0.0, 1.0, 5).state, HealthState::lost);
}

TEST(ScanNovelty, IsOfMovingTurningAndTime) {
  BeamTable beams;
  beams.hits = beams.count = 2;
  beams.range_m = {3.0f, 5.0f};  // a twentieth of 4 m is 0.2 m
  ScanNovelty novelty;
  EXPECT_EQ(novelty.add({}, 0.0, beams), 1.0);
  EXPECT_NEAR(novelty.add({0.05, 0.0, 0.0}, 0.0, beams), 0.25, 1e-6);
  EXPECT_NEAR(novelty.add({0.05, 0.0, 0.05}, 0.0, beams), 0.25, 1e-6);
  EXPECT_NEAR(novelty.add({0.05, 0.0, 0.05}, 0.1, beams), 0.05, 1e-6);
  EXPECT_EQ(novelty.add({5.0, 0.0, 0.0}, 0.1, beams), 1.0);
  beams.hits = 0;
  EXPECT_GT(novelty.add({5.05, 0.0, 0.0}, 0.0, beams), 0.0);
}

std::vector<Particle> cloud(const Pose& at, int count, float weight) {
  std::vector<Particle> particles;
  for (int k = 0; k < count; ++k)
    particles.push_back({static_cast<float>(at.x_m + 0.02 * (k % 5)), static_cast<float>(at.y_m),
                         static_cast<float>(wrap64(at.theta_rad + 0.01 * (k % 3))), weight});
  return particles;
}

TEST(FindModes, HeaviestFirstAndHeadingsAreCyclic) {
  std::vector<Particle> all = cloud({1.0, 1.0, 3.14}, 30, 1.0f);  // across the seam of the headings
  const std::vector<Particle> second = cloud({5.0, -3.0, 0.5}, 60, 1.0f);
  const std::vector<Particle> dust = cloud({-8.0, 2.0, 1.0}, 1, 0.5f);
  all.insert(all.end(), second.begin(), second.end());
  all.insert(all.end(), dust.begin(), dust.end());
  const std::vector<Mode> modes = find_modes(all, 0.02);
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_NEAR(modes[0].weight, 60.0 / 90.5, 1e-6);
  EXPECT_NEAR(modes[0].pose.x_m, 5.04, 1e-5);
  EXPECT_NEAR(modes[1].weight, 30.0 / 90.5, 1e-6);
  EXPECT_NEAR(std::fabs(wrap64(modes[1].pose.theta_rad - 3.15)), 0.0, 1e-5);
  EXPECT_EQ(find_modes(all, 0.001).size(), 3u);
  EXPECT_TRUE(find_modes({}, 0.02).empty());
}

// The estimate's heaviest cluster is found on the device, all modes on the host, in the same bins. The bins
// of the device lie in the grid frame; the map's is the same here. Resampling never happens, so that the
// particles are those that the estimate saw.
TEST(FindModes, TheHeaviestIsTheEstimatesCluster) {
  const GridMap map = test::two_rooms();
  FilterConfig config = test::small_localizer();
  config.resample.threshold = 0.0;
  ParticleFilter filter(config, map);
  const TrialLog log = test::drive(map, TrialTask::track, 1.0, 5);
  const Pose truth = log.truth.front().pose;
  filter.start_at({{truth, 0.1, 0.05, 2.0}, {{truth.x_m - 2.0, truth.y_m, truth.theta_rad}, 0.1, 0.05, 1.0}});
  const Estimate e = filter.step(log.records.front().odometry, log.records.front().scan);
  const std::vector<Mode> modes = find_modes(filter.particles(), 0.0);
  ASSERT_FALSE(modes.empty());
  // Float weights of 600 particles, summed in another order.
  EXPECT_NEAR(modes[0].weight, e.cluster.weight, 1e-5);
  EXPECT_NEAR(modes[0].pose.x_m, e.cluster.mean.x_m, 1e-4);
  EXPECT_NEAR(modes[0].pose.y_m, e.cluster.mean.y_m, 1e-4);
  EXPECT_NEAR(wrap64(modes[0].pose.theta_rad - e.cluster.mean.theta_rad), 0.0, 1e-4);
}

TEST(SlipPrior, IsWiderAndRarerForAWhileAfterAScanThatNothingExplained) {
  const SlipPrior usual = slip_prior({}, 0.2, 0.0, 0), wide = slip_prior({}, 0.2, 0.0, 1);
  EXPECT_GT(wide.sigma_m, usual.sigma_m);
  EXPECT_GT(reach_of(wide).turn_rad, 1.2);  // 70 degrees within one scan: stamps that come in bursts
  EXPECT_LT(wide.odds, 0.1 * usual.odds);
  const SlipPrior later = slip_prior({}, 0.2, 0.0, 7);  // it was carried away, perhaps: others see to that
  EXPECT_EQ(later.sigma_m, usual.sigma_m);
  EXPECT_EQ(later.odds, usual.odds);
  EXPECT_GT(slip_prior({}, 0.2, 10.0, 0).sigma_m, usual.sigma_m);
}

}  // namespace
}  // namespace parloc
