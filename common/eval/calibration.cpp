#include "common/eval/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace parloc {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Rate wilson_rate(std::size_t hits, std::size_t trials) {
  if (trials == 0) return {0, 0, kNan, 0.0, 1.0};
  constexpr double z = 1.959963984540054;  // 95 %, two-sided
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(hits) / n;
  const double scale = 1.0 / (1.0 + z * z / n);
  const double middle = scale * (p + z * z / (2.0 * n));
  const double half = scale * z * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n));
  return {hits, trials, p, std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

CalibrationTally::CalibrationTally()
    : true_(SampleMark::kProbabilities, 0), false_(SampleMark::kProbabilities, 0) {}

void CalibrationTally::add(double probability, bool came_true) {
  ++(came_true ? true_ : false_)[SampleMark::probability_place(probability)];
}
void CalibrationTally::add(SampleMark mark) {
  ++(mark.right() ? true_ : false_)[mark.probability_place()];
}

Calibration CalibrationTally::calibration() const {
  Calibration c;
  c.bins.resize(10);
  double squares = 0.0, won = 0.0, falses_below = 0.0;
  for (std::uint32_t place = 0; place < SampleMark::kProbabilities; ++place) {
    if (true_[place] + false_[place] == 0) continue;
    const double p = SampleMark::probability_at(place);
    const auto trues = static_cast<double>(true_[place]), falses = static_cast<double>(false_[place]);
    squares += trues * (1.0 - p) * (1.0 - p) + falses * p * p;
    won += trues * (falses_below + 0.5 * falses);
    falses_below += falses;
    c.came_true += true_[place];
    c.count += true_[place] + false_[place];
    ReliabilityBin& bin = c.bins[static_cast<std::size_t>(std::min(9.0, std::floor(10.0 * p)))];
    bin.count += true_[place] + false_[place];
    bin.forecast_mean += (trues + falses) * p;
    bin.observed += trues;
  }
  for (ReliabilityBin& bin : c.bins) {
    const auto count = static_cast<double>(bin.count);  // none: 0 / 0 is NaN, as it should be
    bin.forecast_mean /= count;
    bin.observed /= count;
  }
  const auto trues = static_cast<double>(c.came_true);
  c.brier = squares / static_cast<double>(c.count);
  c.auc = trues > 0 && falses_below > 0 ? won / (trues * falses_below) : kNan;
  return c;
}

double expected_calibration_error(const Calibration& calibration) {
  double sum = 0.0;
  for (const ReliabilityBin& bin : calibration.bins)
    if (bin.count > 0) sum += static_cast<double>(bin.count) * std::fabs(bin.forecast_mean - bin.observed);
  return sum / static_cast<double>(calibration.count);  // none: 0 / 0 is NaN, as it should be
}

}  // namespace parloc
