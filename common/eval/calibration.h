// Statistics of yes-or-no outcomes, and whether a probability that was given for them was right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/eval/sample_mark.h"

namespace parloc {

/// A share with its 95 % confidence interval.
struct Rate {
  std::size_t hits = 0, trials = 0;
  double share = 0;          ///< NaN without a trial.
  double low = 0, high = 1;  ///< Wilson 1927.
};
Rate wilson_rate(std::size_t hits, std::size_t trials);

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

/// Counts probabilities that were given for something, and what came true, in memory that does not grow. A
/// probability is counted to 1/65535 (SampleMark). Whatever the order, the same.
class CalibrationTally {
 public:
  CalibrationTally();
  void add(double probability, bool came_true);
  void add(SampleMark mark);
  Calibration calibration() const;

 private:
  std::vector<std::uint64_t> true_, false_;  ///< By the probability's place.
};

/// Mean difference of what was said and what came true, over the bins by their counts (Naeini et al. 2015).
/// NaN without a forecast.
double expected_calibration_error(const Calibration& calibration);

}  // namespace parloc
