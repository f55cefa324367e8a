// Single instructions where machines differ: wide shifts, division by zero, conversions out of range, NaN.
#include "tests/ptx/device/arithmetic.h"

#include <gtest/gtest.h>

namespace ptx {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kWideNan = std::numeric_limits<double>::quiet_NaN();

TEST(Arithmetic, ShiftsByTheWidthAndMore) {
  EXPECT_EQ(shift_left<std::uint32_t>(1, 31), 0x80000000u);
  EXPECT_EQ(shift_left<std::uint32_t>(1, 32), 0u);
  EXPECT_EQ(shift_right<std::uint64_t>(~0ull, 64), 0u);
  EXPECT_EQ(shift_right<std::int32_t>(-5, 40), -1);
  EXPECT_EQ(shift_right<std::int32_t>(5, 40), 0);
}

TEST(Arithmetic, DivisionByZeroAndByMinusOne) {
  EXPECT_EQ(divide<std::uint32_t>(7, 0), ~0u);
  EXPECT_EQ(remainder<std::uint32_t>(7, 0), 7u);
  EXPECT_EQ(divide<std::int32_t>(std::numeric_limits<std::int32_t>::min(), -1),
            std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ(remainder<std::int32_t>(std::numeric_limits<std::int32_t>::min(), -1), 0);
}

TEST(Arithmetic, ConversionsSaturate) {
  EXPECT_EQ(saturate<std::int32_t>(3e9f), 2147483647);
  EXPECT_EQ(saturate<std::int32_t>(-3e9f), std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ(saturate<std::uint32_t>(-1.0f), 0u);
  EXPECT_EQ(saturate<std::uint64_t>(1e30), ~0ull);
  EXPECT_EQ(saturate<std::int32_t>(kNan), 0);
  EXPECT_EQ(saturate<std::int64_t>(kNan), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(saturate<std::int32_t>(kWideNan), std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ((clamp_to<std::uint8_t>(300)), 255);
  EXPECT_EQ((to_float<float>(16777217)), 16777216.0f);
  EXPECT_EQ((to_float<float>(1e-45)), std::numeric_limits<float>::denorm_min());
}

TEST(Arithmetic, NanAndSignedZero) {
  EXPECT_EQ(maximum(kNan, 1.0f), 1.0f);
  EXPECT_EQ(minimum(1.0f, kNan), 1.0f);
  EXPECT_TRUE(std::signbit(minimum(0.0f, -0.0f)));
  EXPECT_FALSE(std::signbit(maximum(-0.0f, 0.0f)));
  EXPECT_EQ(std::bit_cast<std::uint32_t>(add(-kNan, 1.0f)), 0x7fffffffu);
  EXPECT_EQ(add(std::numeric_limits<float>::denorm_min(), 0.0f), std::numeric_limits<float>::denorm_min());
}

TEST(Arithmetic, Bits) {
  EXPECT_EQ(multiply_high<std::uint64_t>(~0ull, ~0ull), ~0ull - 1);
  EXPECT_EQ(multiply_high<std::int32_t>(-1, 1), -1);
  EXPECT_EQ((multiply_wide<std::int64_t, std::int32_t>(-3, 5)), -15);
  EXPECT_EQ(find_leading<std::uint32_t>(0), ~0u);
  EXPECT_EQ(find_leading<std::int32_t>(-1), ~0u);
  EXPECT_EQ(find_leading_shift<std::uint32_t>(1), 31u);
  EXPECT_EQ(leading_zeros<std::uint32_t>(0), 32u);
  EXPECT_EQ(permute(0x33221100, 0x77665544, 0x7e10), 0x77001100u);
  EXPECT_EQ(insert<std::uint32_t>(0xff, 0, 28, 8), 0xf0000000u);
  EXPECT_EQ(extract<std::int32_t>(0xf0, 4, 4), -1);
  EXPECT_EQ(any_of_three(0xf0f0, 0xcccc, 0xaaaa, 0x96), 0xf0f0u ^ 0xccccu ^ 0xaaaau);
  EXPECT_EQ(funnel_left(0x80000000, 1, 1), 3u);
}

}  // namespace
}  // namespace ptx
