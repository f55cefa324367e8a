// Equal to the bit: values, and particles.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <iomanip>
#include <span>

#include "common/filter/filter_backend.h"

namespace parloc::test {

/// If not, how many differ and what the first of them is.
template <class T>
testing::AssertionResult same_bits(std::span<const T> a, std::span<const T> b) {
  if (a.size() != b.size())
    return testing::AssertionFailure() << a.size() << " and " << b.size() << " values";
  const auto differ = [&](std::size_t i) { return std::memcmp(&a[i], &b[i], sizeof(T)) != 0; };
  std::size_t first = a.size(), count = 0;
  for (std::size_t i = a.size(); i-- > 0;)
    if (differ(i)) first = i, ++count;
  if (count == 0) return testing::AssertionSuccess();
  return testing::AssertionFailure() << std::setprecision(17) << count << " of " << a.size()
                                     << " differ, first [" << first << "]: " << a[first] << " and "
                                     << b[first];
}
template <class T>
testing::AssertionResult same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return same_bits(std::span<const T>(a), std::span<const T>(b));
}
/// In the order of Moments' members.
inline testing::AssertionResult same_bits(const Moments& a, const Moments& b) {
  using Values = std::array<double, sizeof(Moments) / sizeof(double)>;
  const auto va = std::bit_cast<Values>(a), vb = std::bit_cast<Values>(b);
  return same_bits(std::span<const double>(va), std::span<const double>(vb));
}

inline void expect_same_bits(const ParticleSet& a, const ParticleSet& b) {
  EXPECT_TRUE(same_bits(a.x, b.x));
  EXPECT_TRUE(same_bits(a.y, b.y));
  EXPECT_TRUE(same_bits(a.theta, b.theta));
  EXPECT_TRUE(same_bits(a.log_weight, b.log_weight));
}

}  // namespace parloc::test
