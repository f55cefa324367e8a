// A rate with an interval that holds however often one looks, and whether it is above or below a bar.
#pragma once

#include <cstddef>
#include <optional>

namespace parloc {

/// Independent trials, each a hit or a miss.
struct RateCounts {
  std::size_t hits = 0, misses = 0;
  std::size_t trials() const { return hits + misses; }
  double share() const { return static_cast<double>(hits) / static_cast<double>(trials()); }
};

struct RateInterval {
  double low = 0.0, high = 1.0;
};

enum class Side { below, open, above };

/// Robbins' mixture (Darling & Robbins 1967, PNAS 58:66-68; Robbins 1970, Ann. Math. Statist. 41:1397-1409,
/// who has its uniform case, P(C(n,s) p^s (1-p)^(n-s) <= error / (n+1) for some n) <= error): of n trials
/// with s hits,
///
///   M_n(p) = B(a + s, b + n - s) / (B(a, b) p^s (1 - p)^(n - s))
///
/// is a martingale of mean 1 if the rate is p, for any a, b > 0. So it ever reaches 1 / error with a
/// probability of at most `error` (Ville 1939), and the rates at which it has not are an interval that holds
/// at all n together. Here a / (a + b) is the bar and the smaller of both is 1: evidence against the bar
/// comes sooner than with a = b = 1 where the bar is near 0 or 1.
///
/// With the rate at the bar M_n is a supermartingale too if trials are drawn without replacement. All bits
/// are the same on every machine.
class RateSequence {
 public:
  /// Both between 0 and 1, exclusive.
  RateSequence(double bar, double error);

  double bar() const { return bar_; }
  double error() const { return error_; }

  /// The side of the bar on which the rate is, once M_n(bar) >= 1 / error. Whoever stops at the first answer
  /// is wrong with a probability of at most `error`.
  Side side(const RateCounts& counts) const;
  /// All rates p with M_n(p) < 1 / error.
  RateInterval interval(const RateCounts& counts) const;
  /// Trials, beyond these, after which side() probably answers if the rate is the share so far: where M_n
  /// gets there along its expected hits. None if that is never, or more than kMostTrials: the share is at the
  /// bar, or there are no trials yet.
  std::optional<std::size_t> more_trials(const RateCounts& counts) const;

  static constexpr double kMostTrials = 1e9;

 private:
  /// Of a rate, below which M_n of it is 1 / error or more.
  double least_log_likelihood(double hits, double misses) const;

  double bar_, error_, a_, b_, log_decisive_;
};

}  // namespace parloc
