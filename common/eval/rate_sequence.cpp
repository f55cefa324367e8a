#include "common/eval/rate_sequence.h"

#include <algorithm>
#include <cmath>

#include "common/math/log_gamma.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

/// Where it no longer holds: halves the way there as often as doubles can tell.
template <class Holds>
double first_outside(double inside, double outside, const Holds& holds) {
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (inside + outside);
    (holds(middle) ? inside : outside) = middle;
  }
  return outside;
}

double log_likelihood(double hits, double misses, double rate) {
  return (hits > 0.0 ? hits * portable_log64(rate) : 0.0) +
         (misses > 0.0 ? misses * portable_log64(1.0 - rate) : 0.0);
}

}  // namespace

RateSequence::RateSequence(double bar, double error)
    : bar_(bar),
      error_(error),
      a_(bar / std::min(bar, 1.0 - bar)),
      b_((1.0 - bar) / std::min(bar, 1.0 - bar)),
      log_decisive_(-portable_log64(error)) {}

/// Of expected hits too, which are no whole numbers.
double RateSequence::least_log_likelihood(double hits, double misses) const {
  return log_beta(a_ + hits, b_ + misses) - log_beta(a_, b_) - log_decisive_;
}

Side RateSequence::side(const RateCounts& counts) const {
  const auto hits = static_cast<double>(counts.hits), misses = static_cast<double>(counts.misses);
  if (log_likelihood(hits, misses, bar_) > least_log_likelihood(hits, misses)) return Side::open;
  return counts.share() > bar_ ? Side::above : Side::below;
}

RateInterval RateSequence::interval(const RateCounts& counts) const {
  if (counts.trials() == 0) return {};
  const auto hits = static_cast<double>(counts.hits), misses = static_cast<double>(counts.misses);
  const double least = least_log_likelihood(hits, misses);
  const auto holds = [&](double rate) { return log_likelihood(hits, misses, rate) > least; };
  return {counts.hits > 0 ? first_outside(counts.share(), 0.0, holds) : 0.0,
          counts.misses > 0 ? first_outside(counts.share(), 1.0, holds) : 1.0};
}

std::optional<std::size_t> RateSequence::more_trials(const RateCounts& counts) const {
  if (counts.trials() == 0) return std::nullopt;
  const double share = counts.share();
  const auto open = [&](double trials) {
    const double hits = share * trials, misses = (1.0 - share) * trials;
    return log_likelihood(hits, misses, bar_) > least_log_likelihood(hits, misses);
  };
  double enough = static_cast<double>(counts.trials());
  if (share == bar_ || !open(enough)) return share == bar_ ? std::nullopt : std::optional<std::size_t>(0);
  double few = enough;
  while (open(enough)) {
    if (enough > kMostTrials) return std::nullopt;
    few = enough;
    enough *= 2.0;
  }
  const double needed = first_outside(few, enough, open);
  return static_cast<std::size_t>(std::ceil(needed)) - counts.trials();
}

}  // namespace parloc
