// Sequences of intervals for a rate and for a difference of rates: values worked out by hand, and how often
// they are wrong where one looks after every trial.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "common/eval/pair_sequence.h"
#include "common/eval/rate_sequence.h"
#include "common/math/log_gamma.h"
#include "common/math/philox.h"

namespace parloc {
namespace {

constexpr double kError = 0.05;

/// Uniform in [0, 1), of the kth trial of a sequence.
double drawn(std::uint32_t sequence, std::size_t k) {
  return uniform_unit(philox(static_cast<std::uint32_t>(k), sequence, 0, 0, 20261201).w[0]);
}

/// At most so many of n sequences are wrong if each is with a probability of at most kError: a correct one
/// fails this with a probability below 1e-4 (3.9 standard deviations of the binomial distribution).
std::size_t most_wrong(std::size_t n) {
  const auto count = static_cast<double>(n);
  return static_cast<std::size_t>(count * kError + 3.9 * std::sqrt(count * kError * (1.0 - kError)));
}

TEST(LogGamma, KnownValues) {
  EXPECT_NEAR(log_gamma(1.0), 0.0, 1e-14);
  EXPECT_NEAR(log_gamma(0.5), 0.5 * std::log(std::acos(-1.0)), 1e-14);
  EXPECT_NEAR(log_gamma(11.0), std::log(3628800.0), 1e-13);
  EXPECT_NEAR(log_beta(2.0, 3.0), -std::log(12.0), 1e-14);
  for (const double x : {1e-3, 0.3, 2.5, 9.99, 10.01, 123.4, 1e6 + 0.5})
    EXPECT_NEAR(log_gamma(x), std::lgamma(x), 2e-15 * std::max(10.0, std::abs(std::lgamma(x)))) << x;
}

TEST(RateSequence, OfHitsAlone) {
  // With the bar at 1/2 the prior is uniform: M_n(p) = 1 / ((n + 1) p^n), 20 or more at 1/2 from n = 8 on.
  const RateSequence half(0.5, kError);
  EXPECT_EQ(half.side({7, 0}), Side::open);
  EXPECT_EQ(half.side({8, 0}), Side::above);
  EXPECT_EQ(half.side({0, 8}), Side::below);
  EXPECT_NEAR(half.interval({10, 0}).low, std::pow(1.0 / 220.0, 0.1), 1e-12);
  EXPECT_EQ(half.interval({10, 0}).high, 1.0);
  EXPECT_NEAR(half.interval({0, 10}).high, 1.0 - std::pow(1.0 / 220.0, 0.1), 1e-12);
  EXPECT_EQ(half.interval({0, 10}).low, 0.0);
  // With the bar at 0.95 it is Beta(19, 1): M_n(p) = 19 / ((19 + n) p^n).
  const RateSequence high(0.95, kError);
  std::size_t n = 1;
  while (19.0 / ((19.0 + static_cast<double>(n)) * std::pow(0.95, static_cast<double>(n))) < 20.0) ++n;
  EXPECT_EQ(n, 93u);
  EXPECT_EQ(high.side({n - 1, 0}), Side::open);
  EXPECT_EQ(high.side({n, 0}), Side::above);
}

TEST(RateSequence, OfBothKinds) {
  // Uniform prior, 3 of 5: M(p) = B(4, 3) / (p^3 (1 - p)^2), B(4, 3) = 1 / 60.
  const RateSequence half(0.5, kError);
  const RateInterval interval = half.interval({3, 2});
  for (const double p : {interval.low, interval.high})
    EXPECT_NEAR(1.0 / (60.0 * p * p * p * (1.0 - p) * (1.0 - p)), 20.0, 1e-9);
  EXPECT_LT(interval.low, 0.6);
  EXPECT_GT(interval.high, 0.6);
  const RateInterval none = half.interval({0, 0});
  EXPECT_EQ(none.low, 0.0);
  EXPECT_EQ(none.high, 1.0);
  EXPECT_EQ(half.side({0, 0}), Side::open);
}

TEST(RateSequence, WhatIsAnsweredIsWhatTheIntervalSays) {
  const RateSequence sequence(0.9, kError);
  for (std::size_t hits = 0; hits <= 60; ++hits)
    for (std::size_t misses = 0; misses <= 60; ++misses) {
      const RateInterval interval = sequence.interval({hits, misses});
      const Side side = sequence.side({hits, misses});
      EXPECT_EQ(side == Side::above, interval.low >= 0.9) << hits << " " << misses;
      EXPECT_EQ(side == Side::below, interval.high <= 0.9) << hits << " " << misses;
    }
}

TEST(RateSequence, HowManyMore) {
  const RateSequence high(0.95, kError);
  EXPECT_EQ(high.more_trials({50, 0}), 43u);           // 93 in all
  EXPECT_EQ(high.more_trials({95, 5}), std::nullopt);  // at the bar
  EXPECT_EQ(high.more_trials({0, 0}), std::nullopt);   // nothing is known
  EXPECT_EQ(high.more_trials({9501, 499}).has_value(), true);
  EXPECT_EQ(high.more_trials({9500001, 499999}), std::nullopt);  // more than a billion
  // Where it is answered once the counts are there.
  const std::size_t more = *high.more_trials({97, 3});
  const std::size_t all = 100 + more, hits = all * 97 / 100;
  EXPECT_EQ(high.side({hits + 2, all - hits - 2}), Side::above);
  EXPECT_EQ(high.side({hits - 2, all - hits + 2}), Side::open);
}

TEST(RateSequence, HowManyMoreIsAboutTheMedian) {
  const RateSequence sequence(0.9, kError);
  const std::size_t expected = 100 + *sequence.more_trials({80, 20});
  std::size_t sooner = 0;
  for (std::uint32_t k = 0; k < 400; ++k) {
    RateCounts counts;
    while (counts.trials() < expected && sequence.side(counts) == Side::open)
      ++(drawn(k, counts.trials()) < 0.8 ? counts.hits : counts.misses);
    sooner += sequence.side(counts) != Side::open ? 1 : 0;
  }
  EXPECT_GT(sooner, 160u);
  EXPECT_LT(sooner, 320u);
}

TEST(RateSequence, IsWrongAsRarelyAsItSays) {
  constexpr std::uint32_t kSequences = 2000;
  for (const double rate : {0.5, 0.9, 0.95}) {
    const RateSequence sequence(rate, kError);  // the hardest: the bar is the rate, and every answer wrong
    std::size_t wrong = 0;
    for (std::uint32_t k = 0; k < kSequences; ++k) {
      RateCounts counts;
      while (counts.trials() < 2000 && sequence.side(counts) == Side::open)
        ++(drawn(k, counts.trials()) < rate ? counts.hits : counts.misses);
      wrong += sequence.side(counts) != Side::open ? 1 : 0;
    }
    EXPECT_LE(wrong, most_wrong(kSequences)) << rate;
    EXPECT_GE(wrong, kSequences / 100) << rate << ": far more careful than it need be";
  }
}

TEST(RateSequence, TheIntervalHoldsAtAllTrialsTogether) {
  constexpr std::uint32_t kSequences = 2000;
  const RateSequence sequence(0.9, kError);
  for (const double rate : {0.7, 0.97}) {
    std::size_t wrong = 0;
    for (std::uint32_t k = 0; k < kSequences; ++k) {
      RateCounts counts;
      bool held = true;
      while (held && counts.trials() < 100) {
        ++(drawn(k, counts.trials()) < rate ? counts.hits : counts.misses);
        const RateInterval interval = sequence.interval(counts);
        held = interval.low <= rate && rate <= interval.high;
      }
      wrong += held ? 0 : 1;
    }
    EXPECT_LE(wrong, most_wrong(kSequences)) << rate;
    EXPECT_GE(wrong, 1u) << rate;
  }
}

// Of a log's starts, which are drawn one after the other until all were there.
TEST(RateSequence, IsNotWrongMoreOftenWithoutReplacement) {
  constexpr std::uint32_t kSequences = 2000;
  const RateSequence sequence(0.9, kError);
  std::size_t wrong = 0;
  for (std::uint32_t k = 0; k < kSequences; ++k) {
    RateCounts left{180, 20}, counts;
    while (left.trials() > 0 && sequence.side(counts) == Side::open) {
      const bool hit = drawn(k, counts.trials()) < left.share();
      --(hit ? left.hits : left.misses);
      ++(hit ? counts.hits : counts.misses);
    }
    wrong += sequence.side(counts) != Side::open ? 1 : 0;
  }
  EXPECT_LE(wrong, most_wrong(kSequences));
}

TEST(PairSequence, KnownValues) {
  // Alike alone: the mixture is 1 / (n + 1), the likelihood of a difference d at most (1 - d)^n.
  const DifferenceInterval alike = difference_interval({100, 0, 0}, kError);
  EXPECT_NEAR(alike.high, 1.0 - std::pow(kError / 101.0, 0.01), 1e-12);
  EXPECT_EQ(alike.low, -alike.high);
  const DifferenceInterval none = difference_interval({}, kError);
  EXPECT_EQ(none.low, -1.0);
  EXPECT_EQ(none.high, 1.0);
  const DifferenceInterval better = difference_interval({500, 10, 90}, kError);
  const DifferenceInterval worse = difference_interval({500, 90, 10}, kError);
  EXPECT_EQ(better.low, -worse.high);
  EXPECT_EQ(better.high, -worse.low);
  EXPECT_GT(better.low, 0.05);
  EXPECT_LT(better.low, 80.0 / 600.0);
  EXPECT_GT(better.high, 80.0 / 600.0);
  EXPECT_LT(better.high, 0.25);
}

/// The likelihood ratio by trying all rates of a fine grid.
TEST(PairSequence, IsTheBestOfAGrid) {
  const PairCounts counts{30, 4, 11};
  const DifferenceInterval found = difference_interval(counts, kError);
  const double log_mixture =
      std::lgamma(4.5) + std::lgamma(11.5) + std::lgamma(31.0) - std::lgamma(47.0) - 2.0 * std::lgamma(0.5);
  double low = 1.0, high = -1.0;
  constexpr int kCells = 1000;
  for (int i = 1; i < kCells; ++i)
    for (int j = 1; i + j < kCells; ++j) {
      const double first = i / double{kCells}, second = j / double{kCells};
      const double log_likelihood =
          4.0 * std::log(first) + 11.0 * std::log(second) + 30.0 * std::log(1.0 - first - second);
      if (log_mixture - log_likelihood >= -std::log(kError)) continue;
      low = std::min(low, second - first);
      high = std::max(high, second - first);
    }
  EXPECT_NEAR(found.low, low, 0.003);
  EXPECT_NEAR(found.high, high, 0.003);
}

TEST(PairSequence, IsWrongAsRarelyAsItSays) {
  constexpr std::uint32_t kSequences = 1000;
  constexpr double kFirst = 0.05, kSecond = 0.15;
  std::size_t wrong = 0;
  for (std::uint32_t k = 0; k < kSequences; ++k) {
    PairCounts counts;
    bool held = true;
    while (held && counts.pairs() < 200) {
      const double draw = drawn(k, counts.pairs());
      ++(draw < kFirst ? counts.first_only : draw < kFirst + kSecond ? counts.second_only : counts.alike);
      const DifferenceInterval interval = difference_interval(counts, kError);
      held = interval.low <= kSecond - kFirst && kSecond - kFirst <= interval.high;
    }
    wrong += held ? 0 : 1;
  }
  EXPECT_LE(wrong, most_wrong(kSequences));
}

}  // namespace
}  // namespace parloc
