#include <cmath>
#include <limits>
#include <utility>

#include "tools/compare/comparison.h"

namespace parloc::tools::compare {
namespace {

template <class Value>
MeanDeviation over(const std::vector<const FilterRun*>& runs, Value value) {
  std::vector<double> values;
  for (const FilterRun* r : runs) values.push_back(value(*r));
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
  std::vector<const FilterRun*> all, kept, lost;
  for (const FilterRun& r : runs) {
    all.push_back(&r);
    (r.lost() ? lost : kept).push_back(&r);
  }
  s.lost = lost.size();
  s.position_rmse_m = over(kept, [](const FilterRun& r) { return r.errors.position_rmse_m; });
  s.position_mae_m = over(kept, [](const FilterRun& r) { return r.errors.position_mae_m; });
  s.position_max_m = over(kept, [](const FilterRun& r) { return r.errors.position_max_m; });
  s.heading_rmse_rad = over(kept, [](const FilterRun& r) { return r.errors.heading_rmse_rad; });
  s.heading_mae_rad = over(kept, [](const FilterRun& r) { return r.errors.heading_mae_rad; });
  s.heading_max_rad = over(kept, [](const FilterRun& r) { return r.errors.heading_max_rad; });
  s.nees = over(kept, [](const FilterRun& r) { return r.nees; });
  s.lost_s = over(lost, [](const FilterRun& r) { return r.lost_s.value(); });
  s.away = over(all, [](const FilterRun& r) { return r.away; }).mean;
  s.particles = over(all, [](const FilterRun& r) { return r.particles; }).mean;
  std::vector<double> steps;
  double scans = 0.0, skipped = 0.0, driven_s = 0.0, working_s = 0.0;
  for (const FilterRun& r : runs) {
    scans += static_cast<double>(r.scans);
    skipped += static_cast<double>(r.skipped);
    driven_s += r.driven_s;
    working_s += r.working_s;
    steps.insert(steps.end(), r.step_s.begin(), r.step_s.end());
  }
  s.skipped = skipped / scans;
  s.real_time_factor = driven_s / working_s;
  s.step = summarise_times(std::move(steps));
  return s;
}

}  // namespace parloc::tools::compare
