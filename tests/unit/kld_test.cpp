// How many particles are enough: known answers of the bound, and the bins that it counts.
#include <gtest/gtest.h>

#include <set>

#include "common/filter/bind.h"
#include "common/math/normal_quantile.h"

namespace parloc {
namespace {

// SPEC 6.1's table of n(k).
TEST(Kld, TheBoundIsFoxs) {
  const std::uint64_t bins[] = {2, 3, 5, 10, 20, 50, 100, 200, 500, 1000};
  struct Row {
    double pf_err, z;
    double particles[10];
  };
  const Row rows[] = {{0.05, 2.3263478740, {66, 93, 134, 217, 363, 750, 1347, 2484, 5755, 11060}},
                      {0.05, 0.99, {20, 37, 66, 131, 250, 588, 1129, 2188, 5303, 10433}},
                      {0.01, 3, {527, 674, 901, 1363, 2150, 4208, 7332, 13213, 29958, 56923}},
                      {0.02, 0.99, {49, 91, 164, 326, 625, 1468, 2822, 5468, 13256, 26081}}};
  for (const Row& row : rows)
    for (std::size_t k = 0; k < 10; ++k) EXPECT_EQ(kld_bound(bins[k], row.pf_err, row.z), row.particles[k]);
}

TEST(Kld, LimitsHoldAndOneBinNeedsTheFewest) {
  const KldRule rule = bind_kld({}, 100, 1000);
  EXPECT_EQ(kld_needed(rule, 0), 100u);
  EXPECT_EQ(kld_needed(rule, 1), 100u);
  EXPECT_EQ(kld_needed(rule, 2), 100u);
  EXPECT_EQ(kld_needed(rule, 10), 217u);
  EXPECT_EQ(kld_needed(rule, 500), 1000u);
}

// The loop relies on it: more bins never need fewer particles, for every quantile that may be configured.
TEST(Kld, TheBoundGrowsWithTheBins) {
  for (const double z : {0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 4.76, 5.0})
    for (std::uint64_t k = 2; k < 5000; ++k)
      ASSERT_LE(kld_bound(k, 0.05, z), kld_bound(k + 1, 0.05, z)) << z << " " << k;
}

TEST(Kld, DeltaAndPfZAreTwoWaysToSayTheSame) {
  KldConfig c;
  EXPECT_NEAR(bind_kld(c, 1, 2).z, 2.3263478740408408, 1e-14);
  c.pf_z = 0.99;
  EXPECT_EQ(bind_kld(c, 1, 2).z, 0.99);
}

// Python's statistics.NormalDist().inv_cdf, which is the same algorithm, and symmetry.
TEST(Kld, NormalQuantiles) {
  const double known[][2] = {{0.5, 0.0},
                             {0.6, 0.2533471031357998},
                             {0.84, 0.994457883209753},
                             {0.95, 1.6448536269514715},
                             {0.99, 2.3263478740408408},
                             {0.999, 3.0902323061678132},
                             {0.999999, 4.753424308822899}};
  for (const auto& [p, z] : known) {
    EXPECT_NEAR(normal_quantile(p), z, 1e-11 + 1e-14 * z);  // 1 - p loses digits in the tail
    EXPECT_NEAR(normal_quantile(1.0 - p), -z, 1e-10);
  }
}

TEST(Kld, BinsOfHeadingGoRoundAndTouchNoNeighbourInX) {
  KldConfig c;
  c.bin_size_xy = 0.25;
  c.bin_size_theta = 0.5;  // 2 pi / 0.5 = 12.57: 13 bins
  const KldRule rule = bind_kld(c, 1, 2);
  EXPECT_EQ(rule.heading_bins, 13);
  std::set<std::uint64_t> bins;
  for (int k = 0; k < 1000; ++k)
    bins.insert(kld_bin(rule, {0.1f, 0.1f, wrap(static_cast<float>(k) * 0.0062832f)}));
  EXPECT_EQ(bins.size(), 13u);
  EXPECT_EQ(kld_bin(rule, {0.01f, 0.24f, 0.0f}), kld_bin(rule, {0.24f, 0.01f, 0.0f}));
  EXPECT_NE(kld_bin(rule, {-0.01f, 0.1f, 0.0f}), kld_bin(rule, {0.01f, 0.1f, 0.0f}));
  EXPECT_NE(kld_bin(rule, {0.26f, 0.1f, 0.0f}), kld_bin(rule, {0.24f, 0.1f, 0.0f}));
}

}  // namespace
}  // namespace parloc
