#include "common/eval/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace parloc {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// By ranks, tied forecasts in one group.
double area_under_curve(std::vector<Forecast> forecasts, std::size_t came_true) {
  const auto trues = static_cast<double>(came_true);
  const auto falses = static_cast<double>(forecasts.size() - came_true);
  std::sort(forecasts.begin(), forecasts.end(),
            [](const Forecast& a, const Forecast& b) { return a.probability < b.probability; });
  double won = 0.0, falses_below = 0.0;
  for (std::size_t begin = 0; begin < forecasts.size();) {
    std::size_t end = begin;
    double trues_here = 0.0, falses_here = 0.0;
    for (; end < forecasts.size() && forecasts[end].probability == forecasts[begin].probability; ++end)
      (forecasts[end].truth ? trues_here : falses_here) += 1.0;
    won += trues_here * (falses_below + 0.5 * falses_here);
    falses_below += falses_here;
    begin = end;
  }
  return trues > 0 && falses > 0 ? won / (trues * falses) : kNan;
}

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

Calibration check_calibration(const std::vector<Forecast>& forecasts) {
  Calibration c;
  c.count = forecasts.size();
  c.bins.resize(10);
  double squares = 0.0;
  for (const Forecast& f : forecasts) {
    const double outcome = f.truth ? 1.0 : 0.0;
    squares += (f.probability - outcome) * (f.probability - outcome);
    c.came_true += f.truth ? 1 : 0;
    ReliabilityBin& bin =
        c.bins[static_cast<std::size_t>(std::clamp(std::floor(10.0 * f.probability), 0.0, 9.0))];
    ++bin.count;
    bin.forecast_mean += f.probability;
    bin.observed += outcome;
  }
  for (ReliabilityBin& bin : c.bins) {
    const auto count = static_cast<double>(bin.count);  // none: 0 / 0 is NaN, as it should be
    bin.forecast_mean /= count;
    bin.observed /= count;
  }
  c.brier = squares / static_cast<double>(c.count);
  c.auc = area_under_curve(forecasts, c.came_true);
  return c;
}

double expected_calibration_error(const Calibration& calibration) {
  double sum = 0.0;
  for (const ReliabilityBin& bin : calibration.bins)
    if (bin.count > 0) sum += static_cast<double>(bin.count) * std::fabs(bin.forecast_mean - bin.observed);
  return sum / static_cast<double>(calibration.count);  // none: 0 / 0 is NaN, as it should be
}

}  // namespace parloc
