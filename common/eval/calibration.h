// Statistics of yes-or-no outcomes, and whether a probability that was given for them was right.
#pragma once

#include <cstddef>
#include <vector>

namespace parloc {

/// A share with its 95 % confidence interval.
struct Rate {
  std::size_t hits = 0, trials = 0;
  double share = 0;          ///< NaN without a trial.
  double low = 0, high = 1;  ///< Wilson 1927.
};
Rate wilson_rate(std::size_t hits, std::size_t trials);

/// A probability that was given for something, and whether it came true.
struct Forecast {
  double probability;
  bool truth;
};

/// Forecasts of one tenth of the probabilities.
struct ReliabilityBin {
  std::size_t count = 0;
  double forecast_mean = 0;  ///< What was said; NaN without a forecast.
  double observed = 0;       ///< How often it came true; NaN likewise.
};

struct Calibration {
  std::size_t count = 0, came_true = 0;
  double brier = 0;  ///< Mean squared difference of probability and outcome (Brier 1950).
  /// Probability that a forecast that came true was given more than one that did not, ties half (Hanley &
  /// McNeil 1982). NaN if all came true or none.
  double auc = 0;
  std::vector<ReliabilityBin> bins;  ///< Ten: [0, 0.1), ..., [0.9, 1].
};
Calibration check_calibration(const std::vector<Forecast>& forecasts);

/// Mean difference of what was said and what came true, over the bins by their counts (Naeini et al. 2015).
/// NaN without a forecast.
double expected_calibration_error(const Calibration& calibration);

}  // namespace parloc
