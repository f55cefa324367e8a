#include "common/eval/trial_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/math/quantile.h"

namespace parloc {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

template <class Holds>
Rate rate_of(const std::vector<TrialResult>& trials, Holds holds) {
  return wilson_rate(
      static_cast<std::size_t>(std::count_if(trials.begin(), trials.end(),
                                             [&](const TrialResult& t) { return holds(t.outcome); })),
      trials.size());
}

void add_rates(const TrialPlan& plan, double limit_s, const std::vector<TrialResult>& trials,
               TrialSummary& s) {
  s.success = rate_of(trials, [&](const TrialOutcome& o) { return succeeded(o, limit_s); });
  s.localized = rate_of(trials, [](const TrialOutcome& o) { return o.localized_after_s.has_value(); });
  const Rate kept = rate_of(
      trials, [](const TrialOutcome& o) { return o.localized_after_s.has_value() && o.wrong_since == 0; });
  s.right_after = wilson_rate(kept.hits, s.localized.hits);
  s.confident_wrong = rate_of(trials, [](const TrialOutcome& o) { return o.confident_wrong > 0; });
  s.confident_wrong_1s = rate_of(trials, [](const TrialOutcome& o) { return o.confident_wrong_s >= 1.0; });
  if (plan.task != TrialTask::kidnap) return;
  s.tracked_before = rate_of(trials, [](const TrialOutcome& o) { return o.tracked_before; });
  // Stamps are sums of decimals: a last bit must not decide.
  s.noticed = rate_of(trials, [&](const TrialOutcome& o) {
    return o.noticed_after_s && *o.noticed_after_s <= plan.grace_s + 1e-9;
  });
}

void add_spreads(const TrialPlan& plan, const std::vector<TrialResult>& trials, TrialSummary& s) {
  std::vector<double> localize_s, notice_s, step_ms, search_ms;
  for (const TrialResult& t : trials) {
    if (t.outcome.localized_after_s) localize_s.push_back(*t.outcome.localized_after_s);
    if (t.outcome.noticed_after_s && plan.task == TrialTask::kidnap)
      notice_s.push_back(*t.outcome.noticed_after_s);
    for (const TrialSample& sample : t.samples)
      (sample.searched ? search_ms : step_ms).push_back(sample.step_ms);
    const auto searches = static_cast<double>(t.searches);
    s.searches_mean += searches / static_cast<double>(trials.size());
    s.searches_most = std::max(s.searches_most, searches);
  }
  s.localize_s = spread_of(std::move(localize_s));
  s.notice_s = spread_of(std::move(notice_s));
  s.step_ms = spread_of(std::move(step_ms));
  s.search_ms = spread_of(std::move(search_ms));
}

void add_errors(const TrialPlan& plan, const std::vector<TrialResult>& trials, TrialSummary& s) {
  std::vector<Forecast> forecasts;
  std::vector<double> nees;
  double squares_m2 = 0.0, missed_s = 0.0, hits = 0.0, unmapped = 0.0;
  std::size_t count = 0;
  for (const TrialResult& t : trials) {
    const TrialOutcome& o = t.outcome;
    s.samples += o.samples;
    s.right_s += o.right_s;
    s.wrong_s += o.wrong_s;
    s.false_lost += o.false_lost;
    missed_s += o.missed_lost_s;
    hits += static_cast<double>(t.hits);
    unmapped += static_cast<double>(t.unmapped);
    squares_m2 += o.squared_error_m2;
    count += o.since_localized;
    if (o.nees_count > 0) nees.push_back(o.nees_sum / static_cast<double>(o.nees_count));
    for (const TrialSample& sample : t.samples)
      forecasts.push_back({sample.probability, is_right(plan, sample)});
  }
  s.unmapped = hits > 0 ? unmapped / hits : kUnknown;
  s.driven_s = s.right_s + s.wrong_s;
  s.false_lost_per_hour = s.right_s > 0 ? static_cast<double>(s.false_lost) * 3600.0 / s.right_s : kUnknown;
  s.missed_lost = s.wrong_s > 0 ? missed_s / s.wrong_s : kUnknown;
  s.rmse_m = count > 0 ? std::sqrt(squares_m2 / static_cast<double>(count)) : kUnknown;
  s.nees = mean_interval(nees);
  s.calibration = check_calibration(forecasts);
}

}  // namespace

Spread spread_of(std::vector<double> values) {
  const std::vector<double> sorted = ascending(std::move(values));
  return {sorted.size(), median(sorted), nearest_rank(sorted, 95), nearest_rank(sorted, 100)};
}

MeanInterval mean_interval(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  if (values.empty()) return {0, kUnknown, kUnknown, kUnknown};
  double sum = 0.0, squares = 0.0;
  for (const double v : values) sum += v;
  const double mean = sum / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const double half = n > 1 ? 1.959963984540054 * std::sqrt(squares / (n - 1) / n) : kUnknown;
  return {values.size(), mean, mean - half, mean + half};
}

bool succeeded(const TrialOutcome& outcome, double limit_s) {
  return outcome.localized_after_s && *outcome.localized_after_s <= limit_s + 1e-9;
}

TrialSummary summarise(const TrialPlan& plan, double limit_s, const std::vector<TrialResult>& trials) {
  TrialSummary s;
  s.trials = trials.size();
  add_rates(plan, limit_s, trials, s);
  add_spreads(plan, trials, s);
  add_errors(plan, trials, s);
  for (const TrialResult& t : trials)
    if (!succeeded(t.outcome, limit_s)) s.failed.push_back(t.seed);
  return s;
}

}  // namespace parloc
