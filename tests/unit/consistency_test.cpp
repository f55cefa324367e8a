// NEES against values worked out by hand, and against draws from a known covariance.
#include <gtest/gtest.h>

#include "common/eval/consistency.h"
#include "common/math/philox.h"

namespace parloc {
namespace {

// The 1e-8 that is added to each variance changes these by less than 1e-6 of them.
TEST(Nees, OfADiagonalCovariance) {
  EXPECT_NEAR(normalised_error_squared({{0.04, 0, 0, 0, 0.01, 0, 0, 0, 0.25}}, 0.2, 0.3, -0.5), 11.0, 1.1e-5);
}

TEST(Nees, OfACorrelatedCovariance) {
  // P = [[2, 1, 0], [1, 2, 0], [0, 0, 1]]: its inverse has 2/3 and -1/3.
  EXPECT_NEAR(normalised_error_squared({{2, 1, 0, 1, 2, 0, 0, 0, 1}}, 1, 1, 0), 2.0 / 3.0, 1e-7);
  EXPECT_NEAR(normalised_error_squared({{2, 1, 0, 1, 2, 0, 0, 0, 1}}, 1, -1, 2), 6.0, 1e-6);
}

TEST(Nees, OfACollapsedSetIsFinite) {
  EXPECT_NEAR(normalised_error_squared({}, 1e-4, 2e-4, 0), 5.0, 1e-9);
  EXPECT_NEAR(normalised_error_squared({{1, 1, 0, 1, 1, 0, 0, 0, 1}}, 0, 2e-4, 0), 2.0, 1e-6);
}

TEST(Nees, OfNoCovarianceIsNotANumber) {
  EXPECT_TRUE(std::isnan(normalised_error_squared({{1, 2, 0, 2, 1, 0, 0, 0, 1}}, 1, 1, 1)));
}

TEST(Consistency, OfAHonestFilterIsThree) {
  constexpr std::size_t n = 20000;
  TrackErrors errors;
  std::vector<StampedCovariance> covariances;
  for (std::size_t k = 0; k < n; ++k) {
    // x = 2 a, y = a + b, heading = 0.1 c with independent unit normals.
    const Normals z = normals(philox(static_cast<std::uint32_t>(k), 0u, 0u, 0u, 7));
    const double stamp_s = static_cast<double>(k);
    errors.stamp_s.push_back(stamp_s);
    errors.x_error_m.push_back(2.0 * z.n[0]);
    errors.y_error_m.push_back(z.n[0] + z.n[1]);
    errors.heading_error_rad.push_back(0.1 * z.n[2]);
    covariances.push_back({stamp_s, {{4, 2, 0, 2, 2, 0, 0, 0, 0.01}}});
  }
  covariances.insert(covariances.begin() + 10, {9.5, {{1, 0, 0, 0, 1, 0, 0, 0, 1}}});  // had no truth
  const Consistency c = check_consistency(errors, covariances);
  EXPECT_EQ(c.compared, n);
  // Chi-square with 3 degrees: mean 3, median 2.366, standard deviation 2.45; five times that / sqrt(n).
  EXPECT_NEAR(c.nees_mean, 3.0, 0.09);
  EXPECT_NEAR(c.nees_median, 2.366, 0.11);
  EXPECT_NEAR(c.within_95, 0.95, 0.008);
  for (const double one : {c.x_mean, c.y_mean, c.heading_mean}) EXPECT_NEAR(one, 1.0, 0.05);
}

TEST(Consistency, OfNothingIsNotANumber) {
  EXPECT_TRUE(std::isnan(check_consistency({}, {}).nees_mean));
}

}  // namespace
}  // namespace parloc
