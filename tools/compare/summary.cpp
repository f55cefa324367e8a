#include <cmath>
#include <limits>

#include "tools/compare/comparison.h"

namespace parloc::compare {
namespace {

template <class Value>
MeanDeviation over(const std::vector<FilterRun>& runs, Value value) {
  std::vector<double> values;
  for (const FilterRun& r : runs) values.push_back(value(r));
  return mean_deviation(values);
}

}  // namespace

MeanDeviation mean_deviation(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double v : values) sum += v;
  const double mean = sum / n;  // none: 0 / 0 is NaN, as it should be
  for (const double v : values) squares += (v - mean) * (v - mean);
  return {mean,
          values.size() > 1 ? std::sqrt(squares / (n - 1.0)) : std::numeric_limits<double>::quiet_NaN()};
}

Summary summarise(const std::vector<FilterRun>& runs) {
  Summary s;
  s.runs = runs.size();
  s.position_rmse_m = over(runs, [](const FilterRun& r) { return r.errors.position_rmse_m; });
  s.position_mae_m = over(runs, [](const FilterRun& r) { return r.errors.position_mae_m; });
  s.position_max_m = over(runs, [](const FilterRun& r) { return r.errors.position_max_m; });
  s.heading_rmse_rad = over(runs, [](const FilterRun& r) { return r.errors.heading_rmse_rad; });
  s.heading_mae_rad = over(runs, [](const FilterRun& r) { return r.errors.heading_mae_rad; });
  s.heading_max_rad = over(runs, [](const FilterRun& r) { return r.errors.heading_max_rad; });
  s.nees = over(runs, [](const FilterRun& r) { return r.nees; });
  s.particles = over(runs, [](const FilterRun& r) { return r.particles; }).mean;
  std::vector<double> kept, steps;
  double scans = 0.0, skipped = 0.0, driven_s = 0.0, working_s = 0.0;
  for (const FilterRun& r : runs) {
    s.lost += r.lost() ? 1 : 0;
    if (!r.lost()) kept.push_back(r.errors.position_rmse_m);
    scans += static_cast<double>(r.scans);
    skipped += static_cast<double>(r.skipped);
    driven_s += r.driven_s;
    working_s += r.working_s;
    steps.insert(steps.end(), r.step_s.begin(), r.step_s.end());
  }
  s.kept_rmse_m = mean_deviation(kept);
  s.skipped = skipped / scans;
  s.real_time_factor = driven_s / working_s;
  s.step = bench::summarise(std::move(steps));
  return s;
}

}  // namespace parloc::compare
