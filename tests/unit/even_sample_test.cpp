// What is kept of a work whose length is not known beforehand.
#include "tools/even_sample.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace parloc::tools
