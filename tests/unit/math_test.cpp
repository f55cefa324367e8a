// The shared arithmetic against published known answers and SPEC's bit patterns (0.1, 0.5, 0.6, 1.7).
#include <gtest/gtest.h>

#include <Random123/philox.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/filter/resampling.h"
#include "common/math/philox.h"
#include "common/math/portable64.h"
#include "common/math/quantile.h"
#include "common/math/sha256.h"
#include "common/model/motion.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

TEST(Philox, EqualsRandom123) {
  r123::Philox4x32 reference;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const std::uint64_t seed = std::uint64_t{i} * 0x9E3779B97F4A7C15u;
    const auto expected =
        reference({{i, i * 7, i * 13, i * 31}},
                  {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}});
    const Philox4x32 r = philox(i, i * 7, i * 13, i * 31, seed);
    for (std::size_t k = 0; k < 4; ++k) ASSERT_EQ(r.w[k], expected[k]) << i;
  }
}

TEST(Philox, NormalsHaveTheSpecifiedBits) {
  const Normals n = normals(philox(0u, 0u, 0u, 0u, 42));
  const std::uint32_t bits[] = {0xbf785e5b, 0x3e46ace1, 0xbf9e28cd, 0x3ff6433e};
  for (int k = 0; k < 4; ++k) EXPECT_EQ(bits_of(n.n[k]), bits[k]);
}

TEST(Portable, HasTheSpecifiedBits) {
  EXPECT_EQ(bits_of(portable_exp(-0.5f)), 0x3f1b4598u);
  EXPECT_EQ(bits_of(portable_exp(-86.5f)), 0x0113bc74u);
  EXPECT_EQ(bits_of(portable_log(1000.0f)), 0x40dd0c55u);
  EXPECT_EQ(bits_of(portable_log(1e-7f)), 0xc180f1dcu);
  EXPECT_EQ(bits_of(portable_sincos(-2.5f).sin), 0xbf193579u);
  EXPECT_EQ(bits_of(portable_sincos(-2.5f).cos), 0xbf4d17c0u);
  EXPECT_EQ(bits_of(wrap(7.0f)), 0x3f37812bu);
  EXPECT_EQ(bits_of(wrap(3.14159274f)), 0xc0490fdau);
}

TEST(Portable, StaysWithinItsStatedErrors) {
  for (float x = 0.0f; x < 9.0f; x += 1e-3f)
    EXPECT_NEAR(portable_erfc(x) / std::erfc(static_cast<double>(x)), 1.0, 5e-6) << x;
  for (int i = -20000; i < 20000; ++i) {
    const double x = 0.0123 * i;
    ASSERT_NEAR(portable_sincos64(x).sin, std::sin(x), 5e-16);
    ASSERT_NEAR(portable_sincos64(x).cos, std::cos(x), 5e-16);
    ASSERT_NEAR(portable_atan2_64(std::sin(0.37 * i), std::cos(0.11 * i)),
                std::atan2(std::sin(0.37 * i), std::cos(0.11 * i)), 5e-16);
  }
}

TEST(Quick, StaysWithinItsStatedErrors) {
  for (float x = -86.0f; x < 20.0f; x += 1.37e-3f)
    ASSERT_NEAR(quick_exp(x) / std::exp(static_cast<double>(x)), 1.0, 3e-7 + 1e-7 * std::fabs(x)) << x;
  for (float x = 1.2e-38f; x < 1e38f; x *= 1.00037f) {
    const double exact = std::log(static_cast<double>(x));
    ASSERT_NEAR(quick_log(x), exact, 6e-7 + 1.2e-7 * std::fabs(exact)) << x;
  }
  for (float x = 0.5f; x < 2.0f; x += 1e-5f)
    ASSERT_NEAR(quick_log(x), std::log(static_cast<double>(x)), 6e-7) << x;
  for (float x = 0.0f; x < 9.0f; x += 1e-3f)
    ASSERT_NEAR(quick_erfc(x) / std::erfc(static_cast<double>(x)), 1.0, 1.2e-5) << x;
}

// Random numbers of all sizes; sums just beside the middle of two floats, where rounding twice goes astray.
TEST(Portable, FusedByDoubleIsFused) {
  std::mt19937 random(9);
  const auto expect_same = [](float a, float b, float c) {
    const float expected = std::fma(a, b, c), got = fused_by_double(a, b, c);
    if (std::isnan(expected))
      ASSERT_TRUE(std::isnan(got)) << a << " " << b << " " << c;
    else
      ASSERT_EQ(bits_of(got), bits_of(expected)) << a << " " << b << " " << c;
  };
  for (int k = 0; k < 2'000'000 && !testing::Test::HasFatalFailure(); ++k) {
    const float a = float_of(static_cast<std::uint32_t>(random())),
                b = float_of(static_cast<std::uint32_t>(random()));
    expect_same(a, b, float_of(static_cast<std::uint32_t>(random())));
    // Of the product's own size, so that bits are lost on both sides.
    const float x = 1.0f + static_cast<float>(random() % 8388608) * 0x1p-23f, y = x * 0.75f;
    for (const float c :
         {0x1p-24f, -0x1p-24f, 0x1p-25f, 0x1p-48f, -0x1p-48f, 0x1p-70f, -0x1p-70f, 1.0f, 0x1p20f, -x * y})
      expect_same(x, y, c);
    expect_same(x, 0x1p-24f * y, x), expect_same(x, -0x1p-24f * y, x);
    expect_same(x * 0x1p-100f, y * 0x1p-40f, 0x1p-140f),
        expect_same(x * 0x1p100f, y * 0x1p27f, -x * 0x1p127f);
  }
}

TEST(Portable, NearestOfIsRint) {
  for (float x = 1e-3f; x < 2.1e9f; x *= 1.00071f)
    for (const float at : {x, -x, std::floor(x) + 0.5f, -std::floor(x) - 0.5f})
      ASSERT_EQ(nearest_of(at), static_cast<std::int32_t>(std::nearbyint(at))) << at;
  EXPECT_EQ(nearest_of(0.0f), 0);
  EXPECT_EQ(nearest_of(-1966080000.0f), -1966080000);
}

// What is too small for a float stays a normal number, so that its logarithm is one: never NaN or infinite.
TEST(Quick, AnswersEverything) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float x : {-87.0f, -1e4f, -1e38f, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_GE(quick_exp(x), 0x1p-126f) << x;
    EXPECT_LE(quick_exp(x), 1e-37f) << x;
  }
  EXPECT_EQ(quick_exp(0.0f), 1.0f);
  EXPECT_EQ(quick_log(1.0f), 0.0f);
}

// The C library's exp and log are right to one unit in the last place; so are these, then, to two.
TEST(Portable64, ExpAndLogAreThoseOfTheLibrary) {
  for (int k = -690; k <= 690; ++k) {
    const double x = k + 0.001 * (k % 7);
    EXPECT_NEAR(portable_exp64(x) / std::exp(x), 1.0, 5e-16) << x;
    const double y = std::exp(0.1 * x) * 1.1;
    EXPECT_NEAR(portable_log64(y), std::log(y), 3e-16 * std::max(1.0, std::fabs(std::log(y)))) << y;
  }
  for (const double y :
       {1.0, 0.7071067811865475, 0.7071067811865477, 1.4142135623730951, 1e-300, 0x1p40, 0.999999})
    EXPECT_NEAR(portable_log64(y), std::log(y), 3e-16 * std::max(1.0, std::fabs(std::log(y)))) << y;
  EXPECT_EQ(portable_log64(1.0), 0.0);
  EXPECT_EQ(portable_exp64(0.0), 1.0);
  EXPECT_EQ(portable_exp64(-1e9), 0.0);
  EXPECT_EQ(portable_exp64(-__builtin_inf()), 0.0);
  EXPECT_EQ(portable_exp64(1e9), portable_exp64(700.0));
}

TEST(Sha256, KnownAnswer) {
  Sha256 sha;
  sha.add("abc", 3);
  EXPECT_EQ(sha.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

// Headings 3 and -3 are 2 pi - 6 apart, across pi.
TEST(Pose, FromOneToAnother) {
  const Pose a{1, 2, 3}, b{4, 6, -3};
  const double turn = 2.0 * kPi - 6.0;
  EXPECT_EQ(distance_m(a, b), 5.0);
  EXPECT_NEAR(turn_rad(a, b), turn, 1e-15);
  EXPECT_EQ(turn_rad(b, a), turn_rad(a, b));
  const Pose at_a = blend(a, b, 0.0), half = blend(a, b, 0.5), at_b = blend(a, b, 1.0);
  expect_equal(at_a, a);
  EXPECT_EQ(half.x_m, 2.5);
  EXPECT_EQ(half.y_m, 4.0);
  EXPECT_NEAR(turn_rad(a, half), 0.5 * turn, 1e-15);
  EXPECT_NEAR(turn_rad(half, b), 0.5 * turn, 1e-15);
  EXPECT_NEAR(at_b.theta_rad, b.theta_rad, 1e-15);
}

TEST(Motion, SpecCheckA) {
  const OdometryIncrement u = odometry_increment({1, 2, 0.5}, {1.3, 2.4, 0.9}, 0.01);
  EXPECT_NEAR(u.rot1_rad, 0.427295218001612, 1e-12);
  EXPECT_NEAR(u.trans_m, 0.5, 1e-12);
  EXPECT_NEAR(u.rot2_rad, -0.027295218001612, 1e-12);
  MotionConfig c;
  c.alpha1 = 0.1, c.alpha2 = 0.05, c.alpha3 = 0.08, c.alpha4 = 0.02;
  const MotionStep m = motion_step(u, c);
  float x = 5, y = -1, theta = -2;
  predict_one(x, y, theta, m, 0, 1, 42);
  EXPECT_EQ(bits_of(x), 0x409e2f36u);
  EXPECT_EQ(bits_of(y), 0xbfc028c1u);
  EXPECT_EQ(bits_of(theta), 0xbfe09cadu);
}

TEST(Motion, BackwardsIsNotATurn) {
  const OdometryIncrement u = odometry_increment({0, 0, 0}, {-0.2, 0, 0}, 0.01);
  const MotionConfig symmetric{.alpha1 = 0.1, .alpha2 = 0.05, .alpha3 = 0.08, .alpha4 = 0.02};
  EXPECT_NEAR(motion_step(u, symmetric).sigma_rot1, 0.010, 1e-6);
}

// SPEC 1.7, F: alpha 0.2 (all five), normals (0.5, -1, 2).
TEST(Motion, OmniSpecCheckF) {
  const OdometryIncrement u = odometry_increment({1, 2, 0.5}, {1.3, 2.4, 0.9}, 1e-12);
  const MotionConfig c{
      .form = MotionForm::omni, .alpha1 = 0.2, .alpha2 = 0.2, .alpha3 = 0.2, .alpha4 = 0.2, .alpha5 = 0.2};
  const MotionStep m = motion_step(u, c);
  for (const float sigma : {m.sigma_trans, m.sigma_rot2, m.sigma_strafe})
    EXPECT_NEAR(sigma, 0.286356421266, 1e-7);
  float x = 5, y = -1, theta = -2;
  predict_omni(x, y, theta, m, Normals{{0.5f, -1.0f, 2.0f}});
  EXPECT_NEAR(x, 4.426060724379, 1e-6);
  EXPECT_NEAR(y, -1.642084043200, 1e-6);
  EXPECT_NEAR(theta, -1.886356421266, 1e-6);
}

// Standing still is uncertain, too: variances add up over the time, however it is cut.
TEST(Motion, TimeAddsNoise) {
  const MotionConfig c{.sigma_rot_per_s = 0.01, .sigma_trans_per_s = 0.02};
  for (const double step_s : {0.025, 0.1, 1.0}) {
    const MotionStep m = motion_step(Movement{{}, step_s}, c);
    EXPECT_NEAR(m.sigma_rot2 * m.sigma_rot2 / step_s, 1e-4, 1e-9);
    EXPECT_NEAR(m.sigma_trans * m.sigma_trans / step_s, 4e-4, 1e-9);
  }
  EXPECT_EQ(motion_step(Movement{{}, 0.0}, c).sigma_rot2, 0.0f);
}

TEST(Motion, AGuessIsAsUncertainAsItIsLong) {
  const MotionStep slow = motion_step(Movement{{0.0, 0.1, 0.0}, 0.1, true}, {});
  const MotionStep fast = motion_step(Movement{{0.0, 2.0, 0.0}, 0.1, true}, {});
  EXPECT_GE(slow.spread_xy, 0.1f);
  EXPECT_GT(fast.spread_xy, 0.9f);
  EXPECT_EQ(motion_step(Movement{{0.0, 0.1, 0.0}, 0.1}, {}).spread_xy, 0.0f);
}

TEST(Motion, ItsShareOfTheParticlesSlips) {
  const MotionConfig c{.slip_share = 0.02};
  const MotionStep m = motion_step(OdometryIncrement{}, c);
  for (const std::uint32_t step : {0u, 1u, 17u}) {
    int slipped = 0;
    for (std::uint32_t slot = 0; slot < 1000; ++slot) slipped += slips(m, slot, step) ? 1 : 0;
    EXPECT_EQ(slipped, 20);
  }
  EXPECT_FALSE(slips(motion_step(OdometryIncrement{}, {}), 0, 0));
}

/// The example of SPEC 5.3: N = 8, S = 40, key (42, 0), step 0.
class SpecResampling : public testing::Test {
 protected:
  std::vector<std::uint64_t> q = {183251937963, 1099511627776, 0,           366503875925, 916259689813,
                                  73300775185,  659706976666,  366503875925};
  std::vector<std::uint64_t> sum, offspring, remainder;
  StepState state;
  void SetUp() override {
    std::uint64_t total = 0;
    for (const std::uint64_t x : q) sum.push_back(total += x);
    state.total = total;
    state.resample = 1;
    std::uint64_t copies = 0, left = 0;
    for (const std::uint64_t x : q) {
      offspring.push_back(copies += whole_copies(x, 8, total));
      remainder.push_back(left += left_over(x, 8, total, remainder_shift(8, total)));
    }
  }
  std::string ancestors(ResampleScheme scheme) {
    ResampleArgs a;
    std::uint32_t count = 8;
    a.from.live = a.to.live = &count;
    a.weights = {q.data(), sum.data()};
    a.scheme = scheme;
    a.key = {42, 0};
    a.state = &state;
    a.offspring_sum = offspring.data();
    a.remainder_sum = remainder.data();
    std::string out;
    for (std::uint64_t j = 0; j < 8; ++j) out += std::to_string(ancestor_of(a, j));
    return out;
  }
};

TEST_F(SpecResampling, GivesTheSpecifiedIndices) {
  EXPECT_EQ(ancestors(ResampleScheme::multinomial), "46377347");
  EXPECT_EQ(ancestors(ResampleScheme::multinomial_linear), "46377347");
  EXPECT_EQ(ancestors(ResampleScheme::systematic), "11134467");
  EXPECT_EQ(ancestors(ResampleScheme::stratified), "11134567");
  EXPECT_EQ(ancestors(ResampleScheme::residual), "11464673");
}

TEST(Quantiles, KeepToTheirDefinitions) {
  const std::vector<double> four = ascending({7.0, 1.0, 3.0, 4.0});
  EXPECT_EQ(median(four), 3.5);
  EXPECT_EQ(upper_median(four), 4.0);
  EXPECT_EQ(nearest_rank(four, 50), 3.0);
  EXPECT_EQ(nearest_rank(four, 51), 4.0);
  EXPECT_EQ(nearest_rank(four, 100), 7.0);
  EXPECT_EQ(interpolated_quantile(four, 0.25), 2.5);
  EXPECT_EQ(median({2.0}), 2.0);
  EXPECT_EQ(interpolated_quantile({2.0}, 0.9), 2.0);
  for (const double none :
       {median({}), upper_median({}), nearest_rank({}, 99), interpolated_quantile({}, 0.5)})
    EXPECT_TRUE(std::isnan(none));
}

}  // namespace
}  // namespace parloc
