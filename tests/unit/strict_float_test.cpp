// A loaded library may have set another rounding mode: loops answer the same on the caller's thread and on
// others, and leave the caller's mode as it was.
#include <gtest/gtest.h>

#include <cfenv>
#include <vector>

#include "cpu/parallel.h"

namespace parloc::cpu {
namespace {

std::vector<float> thirds(int threads) {
  std::vector<float> out(64 * 8);
  float* to = out.data();
  parallel_blocks(out.size(), threads, 64, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t k = begin; k < end; ++k) to[k] = static_cast<float>(k) / 3.0f;
  });
  return out;
}

TEST(StrictFloat, AnotherRoundingModeDoesNotMatterAndIsLeft) {
  const std::vector<float> expected = thirds(1);
  const int before = std::fegetround();
  ASSERT_EQ(std::fesetround(FE_UPWARD), 0);
  const std::vector<float> one = thirds(1), three = thirds(3);
  const int after = std::fegetround();
  std::fesetround(before);
  EXPECT_EQ(after, FE_UPWARD);
  EXPECT_EQ(one, expected);
  EXPECT_EQ(three, expected);
}

}  // namespace
}  // namespace parloc::cpu
