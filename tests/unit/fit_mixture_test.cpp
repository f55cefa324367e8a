// Learning the beam mixture: known numbers come back from ranges drawn from them, and no round makes it
// worse.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/config/config.h"
#include "common/error.h"
#include "common/eval/fit_mixture.h"
#include "common/math/philox.h"

namespace parloc {
namespace {

constexpr double kMax_m = 10.0;

/// A range drawn from the mixture.
float draw(const Mixture& m, double expected_m, std::uint32_t k) {
  const Philox4x32 r = philox(k, 1u, 0u, 0u, 5);
  const double u = uniform_unit(r.w[2]), v = uniform_unit(r.w[3]);
  const double reach_m = std::min(expected_m, kMax_m);
  double range_m = kMax_m;
  if (u < m.z_hit)
    range_m = expected_m < kMax_m ? expected_m + m.sigma_m * normals(r).n[0] : kMax_m;
  else if (u < m.z_hit + m.z_short)
    range_m = -std::log(1.0 - v * (1.0 - std::exp(-m.lambda_per_m * reach_m))) / m.lambda_per_m;
  else if (u < m.z_hit + m.z_short + m.z_rand)
    range_m = v * kMax_m;
  return static_cast<float>(std::fmin(std::fmax(range_m, 0.0), kMax_m));
}

RangePairs drawn(const Mixture& m, std::uint32_t count) {
  RangePairs ranges{kMax_m, {}};
  for (std::uint32_t k = 0; k < count; ++k) {
    // Walls from 1 to 12.5 m: a fifth of the beams expects none, and some stand close to the maximum.
    const double expected_m = 1.0 + 11.5 * uniform_unit(philox(k, 0u, 0u, 0u, 5).w[0]);
    const float seen_m = static_cast<float>(std::fmin(expected_m, kMax_m));
    ranges.pairs.push_back({draw(m, seen_m, k), seen_m});
  }
  return ranges;
}

TEST(FitMixture, KnownNumbersComeBack) {
  const Mixture truths[] = {{0.7, 0.15, 0.05, 0.1, 0.08, 0.6}, {0.4, 0.3, 0.1, 0.2, 0.3, 0.2}};
  for (const Mixture& truth : truths) {
    const MixtureFit fit = fit_mixture(drawn(truth, 40000), {}, 2000, 1e-10);
    const Mixture& m = fit.mixture;
    EXPECT_TRUE(fit.converged);
    // Shares: 4 standard deviations of a count of 40,000 are 0.01. A short beam and a random one look alike
    // where lambda is small, which costs them another 0.01 between each other.
    EXPECT_NEAR(m.z_hit, truth.z_hit, 0.01);
    EXPECT_NEAR(m.z_short, truth.z_short, 0.02);
    EXPECT_NEAR(m.z_max, truth.z_max, 0.01);
    EXPECT_NEAR(m.z_rand, truth.z_rand, 0.02);
    EXPECT_NEAR(m.sigma_m / truth.sigma_m, 1.0, 0.03);
    EXPECT_NEAR(m.lambda_per_m / truth.lambda_per_m, 1.0, 0.15);
  }
}

TEST(FitMixture, NoRoundMakesItWorse) {
  const RangePairs ranges = drawn({0.6, 0.2, 0.1, 0.1, 0.1, 0.5}, 5000);
  const Mixture starts[] = {{}, {0.25, 0.25, 0.25, 0.25, 2.0, 5.0}, {0.97, 0.01, 0.01, 0.01, 0.01, 0.01}};
  for (const Mixture& start : starts) {
    const MixtureFit fit = fit_mixture(ranges, start, 300, 0.0);
    ASSERT_GT(fit.log_likelihood.size(), 5u);
    for (std::size_t k = 1; k < fit.log_likelihood.size(); ++k)
      ASSERT_GE(fit.log_likelihood[k], fit.log_likelihood[k - 1] - 1e-12) << k;  // the rounding of a sum
    EXPECT_GT(fit.log_likelihood.back(), fit.log_likelihood.front() + 0.01);
  }
}

TEST(FitMixture, TheLikelihoodIsAProbability) {
  const Mixture m{0.6, 0.2, 0.1, 0.1, 0.1, 0.5};
  for (const float expected_m : {1.0f, 5.0f, 9.9f, 10.0f}) {
    double mass = mixture_likelihood(m, {10.0f, expected_m}, kMax_m);
    constexpr int n = 100000;
    for (int k = 0; k < n; ++k)
      mass += mixture_likelihood(m, {static_cast<float>((k + 0.5) * kMax_m / n), expected_m}, kMax_m) *
              kMax_m / n;
    EXPECT_NEAR(mass, 1.0, 1e-4) << expected_m;
  }
}

TEST(FitMixture, WhatItLearnsIsAConfiguration) {
  const Mixture m{0.9999, 0.0, 0.0, 0.0001, 0.0431234, 0.0};
  Config config;
  config.sensor = with_mixture(default_sensor(SensorModel::class_conditional), m);
  EXPECT_NO_THROW(validate(config));
  EXPECT_EQ(config.sensor.sigma_hit, 0.0431);
}

TEST(FitMixture, TooFewBeamsAreAnError) {
  EXPECT_THROW(fit_mixture(drawn({}, 99), {}), Error);
}

}  // namespace
}  // namespace parloc
