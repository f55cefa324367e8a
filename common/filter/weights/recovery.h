// Augmented recovery (Thrun, Burgard & Fox 2005, table 8.3) in logarithms and per beam (SPEC 6.3): two
// running means of how likely the scans are; while the fast one is below the slow one by more than a margin
// (Gutmann & Fox 2002), some of the offspring are drawn from free space.
//
// The mean is geometric over the beams of a scan: the product over beams spans hundreds of decades, so that
// its running mean would be the value of one scan. And it is a mean over the particles, not a sum, so that it
// does not change with their number.
#pragma once

#include "common/filter/stages.h"
#include "common/math/fixed_point.h"
#include "common/math/portable64.h"

namespace parloc {

/// log(exp(a) + exp(b))
PARLOC_HD double log_of_sum(double a, double b) {
  const double high = a > b ? a : b, low = a > b ? b : a;
  return high + portable_log64(1.0 + portable_exp64(low - high));
}

/// Takes in a scan of this log-likelihood per beam.
PARLOC_HD void average_likelihood(LikelihoodMeans& means, double scan, const RecoveryRates& rates) {
  const bool first = means.scans == 0;
  means.scan = scan;
  means.scans = 1;
  if (!rates.on) return;
  means.slow = first ? scan : log_of_sum(rates.keep_slow + means.slow, rates.add_slow + scan);
  means.fast = first ? scan : log_of_sum(rates.keep_fast + means.fast, rates.add_fast + scan);
}

/// Share of the offspring to be drawn from free space.
PARLOC_HD double injected_share(const LikelihoodMeans& means, const RecoveryRates& rates) {
  const double excess = means.fast - means.slow + rates.margin;
  return rates.on && excess < 0.0 ? 1.0 - portable_exp64(excess) : 0.0;
}

/// Log-likelihood per beam of a scan that counts for `worth` independent beams and after which the weights
/// sum to `total`, at a largest log-weight of max_log_weight; before it they summed to `before`, at 0.
PARLOC_HD double scan_log_likelihood(const StepState& state, std::uint64_t total, std::uint64_t before,
                                     float worth) {
  if (state.degenerate != 0) return static_cast<double>(kLogLikelihoodFloor);
  const double ratio = static_cast<double>(total) / static_cast<double>(before);
  return (static_cast<double>(state.max_log_weight) + portable_log64(ratio)) / static_cast<double>(worth);
}

}  // namespace parloc
