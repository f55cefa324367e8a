// Wilson's interval, Brier score, AUC and reliability against values worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "common/eval/calibration.h"

namespace parloc {
namespace {

constexpr double kStep = 1.0 / 65535.0;  // to which probabilities are counted

Calibration calibration_of(const std::vector<std::pair<double, bool>>& forecasts) {
  CalibrationTally tally;
  for (const auto& [probability, came_true] : forecasts) tally.add(probability, came_true);
  return tally.calibration();
}

TEST(WilsonRate, KnownIntervals) {
  // 8 of 10: Brown, Cai & DasGupta 2001 give (0.490, 0.943).
  const Rate some = wilson_rate(8, 10);
  EXPECT_DOUBLE_EQ(some.share, 0.8);
  EXPECT_NEAR(some.low, 0.4902, 5e-5);
  EXPECT_NEAR(some.high, 0.9433, 5e-5);
  // All of n: the lower end is n / (n + z^2).
  const Rate all = wilson_rate(20, 20);
  EXPECT_NEAR(all.low, 20.0 / (20.0 + 3.8414588), 1e-7);
  EXPECT_EQ(all.high, 1.0);
  EXPECT_EQ(wilson_rate(0, 20).low, 0.0);
  EXPECT_TRUE(std::isnan(wilson_rate(0, 0).share));
}

TEST(Calibration, OfAHandfulOfForecasts) {
  const Calibration c =
      calibration_of({{0.9, true}, {0.8, true}, {0.8, false}, {0.2, false}, {0.1, true}, {1.0, true}});
  EXPECT_EQ(c.came_true, 4u);
  EXPECT_NEAR(c.brier, (0.01 + 0.04 + 0.64 + 0.04 + 0.81 + 0.0) / 6.0, 2.0 * kStep);
  // Pairs (true, false): 0.9 beats both, 0.8 ties one and beats one, 0.1 beats none, 1.0 beats both.
  EXPECT_NEAR(c.auc, (2.0 + 1.5 + 0.0 + 2.0) / 8.0, 1e-12);
  EXPECT_EQ(c.bins[8].count, 2u);
  EXPECT_NEAR(c.bins[8].observed, 0.5, 1e-12);
  EXPECT_EQ(c.bins[9].count, 2u);
  EXPECT_NEAR(c.bins[9].forecast_mean, 0.95, kStep);
  EXPECT_TRUE(std::isnan(c.bins[5].observed));
}

TEST(Calibration, OfOneKindHasNoArea) {
  EXPECT_TRUE(std::isnan(calibration_of({{0.5, true}, {0.7, true}}).auc));
  EXPECT_TRUE(std::isnan(calibration_of({}).brier));
}

}  // namespace
}  // namespace parloc
