// What is kept of a work whose length is not known beforehand.
#include "tools/report/even_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace parloc::tools {
namespace {

std::vector<int> kept_of(int steps) {
  EvenSample<int> sample(12);
  for (int k = 0; k < steps; ++k) sample.offer([&] { return k; });
  sample.finish([&] { return steps - 1; });
  return sample.take();
}

TEST(EvenSample, KeepsTheEndsAndEvenStepsBetween) {
  EXPECT_EQ(kept_of(1), std::vector<int>{0});
  for (int steps = 2; steps < 300; ++steps) {
    const std::vector<int> kept = kept_of(steps);
    ASSERT_LE(kept.size(), 13u) << steps;
    ASSERT_GE(kept.size(), static_cast<std::size_t>(std::min(steps, 7))) << steps;
    EXPECT_EQ(kept.front(), 0);
    EXPECT_EQ(kept.back(), steps - 1);
    std::set<int> strides;
    for (std::size_t k = 1; k + 1 < kept.size(); ++k) strides.insert(kept[k] - kept[k - 1]);
    EXPECT_LE(strides.size(), 1u) << steps;
    EXPECT_GT(kept.back(), kept.size() > 1 ? kept[kept.size() - 2] : -1);
  }
}

TEST(EvenSample, MakesOnlyWhatItKeeps) {
  EvenSample<int> sample(12);
  int made = 0;
  for (int k = 0; k < 10000; ++k) sample.offer([&] { return ++made; });
  EXPECT_LT(made, 100);  // 13 at first, then 6 for every doubling of the stride
}

TEST(EvenSample, GoesOnAsIfThereHadBeenNoBreak) {
  for (int steps = 1; steps < 200; ++steps)
    for (const int before : {0, 1, 12, 13, 40, 97}) {
      if (before > steps) continue;
      EvenSample<int> first(12), second(12);
      for (int k = 0; k < before; ++k) first.offer([&] { return k; });
      ASSERT_TRUE(second.restore(first.take(), static_cast<std::size_t>(before)));
      for (int k = before; k < steps; ++k) second.offer([&] { return k; });
      second.finish([&] { return steps - 1; });
      EXPECT_EQ(second.take(), kept_of(steps)) << before << " of " << steps;
    }
  EXPECT_FALSE(EvenSample<int>(12).restore({0, 1}, 30));
}

}  // namespace
}  // namespace parloc::tools
