// The running means of augmented recovery against numbers worked out elsewhere, and poses from free space.
#include "common/filter/weights/recovery.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/filter/bind.h"
#include "common/filter/free_space.h"
#include "common/filter/weights/normalise.h"

namespace parloc {
namespace {

RecoveryRates rates_of(double slow, double fast, double margin) {
  return bind_recovery({.recovery_alpha_slow = slow, .recovery_alpha_fast = fast, .recovery_margin = margin});
}

std::vector<double> shares(const std::vector<double>& scans, double slow, double fast, double margin = 1.0) {
  const RecoveryRates rates = rates_of(slow, fast, margin);
  LikelihoodMeans means;
  std::vector<double> out;
  for (const double scan : scans) {
    average_likelihood(means, scan, rates);
    out.push_back(injected_share(means, rates));
  }
  return out;
}

// SPEC 6.3, to the digits given there.
TEST(Recovery, SharesInLogarithms) {
  const std::vector<double> p = shares({-1.2, -1.25, -1.2, -3, -3}, 0.01, 0.3);
  const double known[] = {0, 0.014150368111, 0.009763706355, 0.250969404492, 0.420821505572};
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(p[k], known[k], 1e-12);
}

// The textbook's means of likelihoods, whose logarithms are what goes in.
TEST(Recovery, SharesOfPlainLikelihoods) {
  std::vector<double> scans;
  for (const double a : {1.0, 1.0, 0.9, 1.0, 0.2, 0.2, 0.2, 0.2, 0.9}) scans.push_back(std::log(a));
  const std::vector<double> p = shares(scans, 0.001, 0.1);
  const double known[] = {0,           0,           0.009900990, 0.008900989, 0.087278733,
                          0.157859287, 0.221416721, 0.278648259, 0.260414172};
  for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(p[k], known[k], 1e-9);
}

TEST(Recovery, TheMarginIsAFactor) {
  const std::vector<double> scans = {0.0, std::log(0.2), std::log(0.2), std::log(0.2)};
  const std::vector<double> none = shares(scans, 0.001, 0.5), twice = shares(scans, 0.001, 0.5, 2.0);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(twice[k], std::max(0.0, 1.0 - 2.0 * (1.0 - none[k])), 1e-14);
  EXPECT_EQ(twice[1], 0.0);  // 0.6 of 0.9992
  EXPECT_GT(twice[3], 0.3);  // 0.3 of 0.9976
}

TEST(Recovery, OffMeansNeverThoughTheLikelihoodIsKept) {
  LikelihoodMeans means;
  for (const double scan : {-1.0, -9.0}) average_likelihood(means, scan, bind_recovery({}));
  EXPECT_EQ(injected_share(means, bind_recovery({})), 0.0);
  EXPECT_EQ(means.scan, -9.0);
}

/// The tail of normalise_scan for given sums.
struct Tail {
  static constexpr std::size_t kCapacity = 1000;
  std::uint32_t count = 10;
  float worth = 4.0f;
  StepState state;
  RecoveryRates rates;

  void scan(float max_log_weight, std::uint64_t total) {
    NormaliseArgs a;
    a.particles.live = &count;
    a.particles.capacity = kCapacity;
    a.threshold = 0.0;
    a.state = &state;
    a.recovery = rates;
    StepInput input;
    input.scan_worth = worth;
    a.input = &input;
    state.max_log_weight = max_log_weight;
    finish_normalising(a, total, 1.0);
  }
};

// Weights before and after, by hand: ten particles of weight 1, whose likelihoods sum to 3 e^-8; then, not
// resampled, from those 3 to 1.5 e^-2; then, after resampling to 6 particles, to 6 e^-1.
TEST(Recovery, ALikelihoodIsAMeanOverWhatTheWeightsWere) {
  const std::uint64_t one = std::uint64_t{1} << weight_bits(Tail::kCapacity);
  Tail t;
  t.scan(-8.0f, 3 * one);
  EXPECT_NEAR(t.state.likelihood.scan, (-8.0 + std::log(3.0 / 10.0)) / 4.0, 1e-15);
  t.scan(-2.0f, one + one / 2);
  EXPECT_NEAR(t.state.likelihood.scan, (-2.0 + std::log(1.5 / 3.0)) / 4.0, 1e-15);
  t.state.resample = 1, t.count = 6;
  t.scan(-1.0f, 6 * one);
  EXPECT_NEAR(t.state.likelihood.scan, -1.0 / 4.0, 1e-15);
}

TEST(Recovery, AStepWithoutAScanSaysNothing) {
  const std::uint64_t one = std::uint64_t{1} << weight_bits(Tail::kCapacity);
  Tail t;
  t.rates = rates_of(0.1, 0.5, 1.0);
  t.scan(-1.0f, 10 * one);
  t.scan(-9.0f, 10 * one);
  EXPECT_GT(t.state.inject, 0.1);
  EXPECT_EQ(t.state.resample, 1u);  // whatever N_eff says
  const double fast = t.state.likelihood.fast;
  t.worth = 0.0f;
  t.scan(0.0f, 10 * one);
  EXPECT_EQ(t.state.inject, 0.0);
  EXPECT_EQ(t.state.likelihood.fast, fast);
}

// Each pose lies in a free cell, and all of these are met.
TEST(FreeSpace, PosesLieInFreeCells) {
  const std::vector<std::uint32_t> cells = {3, 12, 25, 39};
  const FreeSpace free{cells.data(), 4, 10, 0.5f};
  std::vector<int> met(4);
  std::size_t injected = 0;
  for (std::uint32_t j = 0; j < 4000; ++j) {
    const GridPose p = injected_pose(free, j, {7, 3});
    const std::uint32_t cell =
        static_cast<std::uint32_t>(p.y / 0.5f) * 10 + static_cast<std::uint32_t>(p.x / 0.5f);
    const auto at = std::find(cells.begin(), cells.end(), cell);
    ASSERT_NE(at, cells.end()) << p.x << " " << p.y;
    ++met[static_cast<std::size_t>(at - cells.begin())];
    injected += is_injected(free, 0.2, j, {7, 3}) ? 1 : 0;
    EXPECT_FALSE(is_injected(free, 0.0, j, {7, 3}));
    EXPECT_FALSE(is_injected({}, 0.2, j, {7, 3}));
  }
  for (const int times : met) EXPECT_NEAR(times, 1000, 140);  // 5 standard deviations
  EXPECT_NEAR(static_cast<double>(injected), 800.0, 130.0);
}

// SPEC 6.2: slots 0 and 1 of seed 42 on a map of 75316 free cells.
TEST(FreeSpace, KnownPoses) {
  std::vector<std::uint32_t> cells(75316);
  for (std::uint32_t c = 0; c < cells.size(); ++c) cells[c] = c;
  const FreeSpace free{cells.data(), 75316, 1u << 20, 1.0f};
  const GridPose first = injected_pose(free, 0, {42, 0}), second = injected_pose(free, 1, {42, 0});
  EXPECT_EQ(static_cast<int>(first.x), 39081);
  EXPECT_EQ(static_cast<int>(second.x), 58216);
  EXPECT_NEAR(first.y, 0.711674571037, 1e-7);
  EXPECT_NEAR(second.y, 0.773935019970, 1e-7);
  EXPECT_NEAR(first.theta, -0.364808794288, 1e-6);
  EXPECT_NEAR(second.theta, 0.697734307229, 1e-6);
}

}  // namespace
}  // namespace parloc
