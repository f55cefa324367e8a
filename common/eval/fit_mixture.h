// The six numbers of the beam mixture from measured and expected ranges, by expectation-maximisation: Thrun,
// Burgard & Fox, Probabilistic Robotics, table 6.2, for the censored mixture of SPEC 3.3.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/filter/filter_config.h"

namespace parloc {

/// A beam, and what the map says that it should have measured. Beyond the maximum range: `range_max_m`.
struct RangePair {
  float measured_m = 0.0f;
  float expected_m = 0.0f;
};

/// Measured and expected ranges of one sensor.
struct RangePairs {
  double range_max_m = 0.0;
  std::vector<RangePair> pairs;
};

struct Mixture {
  double z_hit = 0.7, z_short = 0.1, z_max = 0.1, z_rand = 0.1;
  double sigma_m = 0.2;
  double lambda_per_m = 0.5;
};

/// Beams that six numbers can be learned from at all.
constexpr std::size_t kFewestPairs = 100;

struct MixtureFit {
  Mixture mixture;
  std::vector<double> log_likelihood;  ///< Per beam, before each round; it never falls.
  bool converged = false;              ///< Else the rounds were used up, or the caller stopped it.
};

/// Rounds until the log-likelihood per beam grows by less than `least_gain`. The hit's tail beyond the
/// maximum and the short's truncation at the expected range are part of the maximisation, which is exact for
/// the shares and sigma and a step uphill for lambda. `keep_going`, if given, is asked after every round.
/// Throws Error{input} for fewer than kFewestPairs.
MixtureFit fit_mixture(const RangePairs& ranges, Mixture start, int most_rounds = 200,
                       double least_gain = 1e-7, const std::function<bool(int round)>& keep_going = {});

/// Density [1/m] of a measured range below the maximum, or the probability of a measured miss.
double mixture_likelihood(const Mixture& m, const RangePair& pair, double range_max_m);

/// Into a configuration. Shares that the filter needs above 0 (z_max, z_rand, and z_short for
/// class_conditional) become at least 0.001.
SensorConfig with_mixture(SensorConfig config, const Mixture& m);

}  // namespace parloc
