// `parloc bench`: how numbers come from times, and the largest size by bisection.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/unit/timing_rules.h"
#include "tools/bench/steps/measure.h"
#include "tools/report/machine/statistics.h"

namespace parloc::tools::bench {
namespace {

TEST(Statistics, OfKnownTimes) {
  std::vector<double> times(100);
  std::iota(times.begin(), times.end(), 1.0);
  std::reverse(times.begin(), times.end());
  const TimeSummary s = summarise_times(times);
  EXPECT_EQ(s.count, 100u);
  EXPECT_DOUBLE_EQ(s.median_s, 50.5);
  EXPECT_DOUBLE_EQ(s.p99_s, 99.0);
  EXPECT_DOUBLE_EQ(s.q1_s, 25.75);
  EXPECT_DOUBLE_EQ(s.q3_s, 75.25);
  EXPECT_DOUBLE_EQ(s.least_s, 1.0);
  EXPECT_DOUBLE_EQ(s.most_s, 100.0);
}

TEST(Statistics, OfFewTimes) {
  const TimeSummary none = summarise_times({});
  EXPECT_EQ(none.count, 0u);
  EXPECT_EQ(none.median_s, 0.0);
  const TimeSummary one = summarise_times({3.0});
  EXPECT_EQ(one.median_s, 3.0);
  EXPECT_EQ(one.p99_s, 3.0);
  EXPECT_EQ(one.q1_s, 3.0);
  const TimeSummary odd = summarise_times({9.0, 1.0, 2.0});
  EXPECT_EQ(odd.median_s, 2.0);
  EXPECT_EQ(odd.p99_s, 9.0);  // of fewer than 100 the longest
  EXPECT_EQ(odd.q1_s, 1.5);
  EXPECT_EQ(odd.q3_s, 5.5);
}

TEST(Measure, CountsStepsAfterTheWarmUp) {
  int steps = 0;
  const auto step = [&] { return static_cast<double>(++steps); };
  const auto time = measure(step, rules_of(0.0, 7, 1000), {});
  ASSERT_TRUE(time);
  EXPECT_EQ(steps, 9);
  EXPECT_EQ(time->count, 7u);
  EXPECT_EQ(time->least_s, 3.0);  // the two of the warm-up are not in it
  EXPECT_EQ(time->median_s, 6.0);
  EXPECT_EQ(measure(step, rules_of(3600.0, 7, 20), {})->count, 20u);
}

TEST(Measure, EndsEarlyWhenAsked) {
  int steps = 0;
  const auto step = [&] { return static_cast<double>(++steps); };
  Control stopped;
  stopped.stop = [&] { return steps >= 5; };
  EXPECT_FALSE(measure(step, rules_of(0.0, 100, 1000), stopped));
  EXPECT_EQ(steps, 5);
  Control late;
  late.deadline = Clock::now();
  steps = 0;
  EXPECT_EQ(measure(step, rules_of(0.0, 100, 1000), late)->count, 1u);
  EXPECT_EQ(steps, 2);
}

TEST(Measure, LongStepsAreRepeatedLess) {
  TimingRules rules = rules_of(0.0, 100, 1000);
  rules.long_seconds = 0.0;
  int steps = 0;
  EXPECT_EQ(measure([&] { return static_cast<double>(++steps); }, rules, {})->count, 3u);
  EXPECT_EQ(steps, 4);
}

TEST(Bisect, FindsTheLargest) {
  for (const std::int64_t truth : {64, 65, 700, 12'345, 999'999}) {
    for (const std::int64_t guess : {1, 100, 10'000, 100'000'000}) {
      int calls = 0;
      const auto found = largest_that_fits(64, 1'000'000, guess, 0.02, [&](std::int64_t n) {
        ++calls;
        return std::optional<bool>(n <= truth);
      });
      ASSERT_TRUE(found);
      EXPECT_LE(found->fits, truth);
      EXPECT_GT(found->too_many, truth);
      const bool close = static_cast<double>(found->too_many) <= 1.02 * static_cast<double>(found->fits);
      EXPECT_TRUE(close || found->too_many - found->fits == 1) << found->fits << ' ' << found->too_many;
      EXPECT_LE(calls, 24) << truth << ' ' << guess;  // 14 doublings at most, 6 halvings to 2 %
    }
  }
}

TEST(Bisect, AtTheEnds) {
  const auto all =
      largest_that_fits(64, 1000, 200, 0.02, [](std::int64_t) { return std::optional<bool>(true); });
  EXPECT_EQ(all->fits, 1000);
  EXPECT_EQ(all->too_many, 0);
  const auto none =
      largest_that_fits(64, 1000, 200, 0.02, [](std::int64_t) { return std::optional<bool>(false); });
  EXPECT_EQ(none->fits, 0);
  EXPECT_EQ(none->too_many, 64);
  EXPECT_FALSE(largest_that_fits(64, 1000, 200, 0.02, [](std::int64_t) { return std::optional<bool>(); }));
}

}  // namespace
}  // namespace parloc::tools::bench
