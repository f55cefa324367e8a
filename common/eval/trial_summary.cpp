#include "common/eval/trial_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace parloc {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Takes in one trial after the other.
class Tally {
 public:
  Tally(const TrialPlan& plan, double limit_s) : plan_(plan), limit_s_(limit_s) {}
  void add(const TrialResult& trial);
  TrialSummary summary() const;

 private:
  void count(const TrialResult& trial);
  void add_rates(TrialSummary& s) const;
  void add_errors(TrialSummary& s) const;

  const TrialPlan& plan_;
  double limit_s_;
  TrialSummary sums_;  ///< What is a sum already.
  std::size_t succeeded_ = 0, localized_ = 0, kept_ = 0, wrong_ = 0, wrong_1s_ = 0, tracked_ = 0,
              noticed_ = 0;
  std::vector<double> localize_s_, notice_s_, nees_;
  double squares_m2_ = 0.0, missed_s_ = 0.0, hits_ = 0.0, unmapped_ = 0.0, searches_ = 0.0;
  std::size_t since_ = 0;
  TimeTally step_, search_;
  CalibrationTally calibration_;
};

void Tally::count(const TrialResult& trial) {
  const TrialOutcome& o = trial.outcome;
  if (succeeded(o, limit_s_))
    ++succeeded_;
  else
    sums_.failed.push_back(trial.seed);
  if (o.localized_after_s) {
    ++localized_;
    kept_ += o.wrong_since == 0 ? 1 : 0;
    localize_s_.push_back(*o.localized_after_s);
  }
  wrong_ += o.confident_wrong > 0 ? 1 : 0;
  wrong_1s_ += o.confident_wrong_s >= 1.0 ? 1 : 0;
  if (plan_.task != TrialTask::kidnap) return;
  tracked_ += o.tracked_before ? 1 : 0;
  if (!o.noticed_after_s) return;
  // Stamps are sums of decimals: a last bit must not decide.
  noticed_ += *o.noticed_after_s <= plan_.grace_s + 1e-9 ? 1 : 0;
  notice_s_.push_back(*o.noticed_after_s);
}

void Tally::add(const TrialResult& trial) {
  const TrialOutcome& o = trial.outcome;
  ++sums_.trials;
  count(trial);
  sums_.samples += o.samples;
  sums_.right_s += o.right_s;
  sums_.wrong_s += o.wrong_s;
  sums_.false_lost += o.false_lost;
  missed_s_ += o.missed_lost_s;
  hits_ += static_cast<double>(trial.hits);
  unmapped_ += static_cast<double>(trial.unmapped);
  squares_m2_ += o.squared_error_m2;
  since_ += o.since_localized;
  if (o.nees_count > 0) nees_.push_back(o.nees_sum / static_cast<double>(o.nees_count));
  searches_ += static_cast<double>(trial.searches);
  sums_.searches_most = std::max(sums_.searches_most, static_cast<double>(trial.searches));
  for (const SampleMark mark : trial.marks) {
    calibration_.add(mark);
    (mark.searched() ? search_ : step_).add(mark);
  }
}

void Tally::add_rates(TrialSummary& s) const {
  s.success = wilson_rate(succeeded_, s.trials);
  s.localized = wilson_rate(localized_, s.trials);
  s.right_after = wilson_rate(kept_, localized_);
  s.confident_wrong = wilson_rate(wrong_, s.trials);
  s.confident_wrong_1s = wilson_rate(wrong_1s_, s.trials);
  if (plan_.task != TrialTask::kidnap) return;
  s.tracked_before = wilson_rate(tracked_, s.trials);
  s.noticed = wilson_rate(noticed_, s.trials);
}

void Tally::add_errors(TrialSummary& s) const {
  s.unmapped = hits_ > 0 ? unmapped_ / hits_ : kUnknown;
  s.driven_s = s.right_s + s.wrong_s;
  s.false_lost_per_hour = s.right_s > 0 ? static_cast<double>(s.false_lost) * 3600.0 / s.right_s : kUnknown;
  s.missed_lost = s.wrong_s > 0 ? missed_s_ / s.wrong_s : kUnknown;
  s.rmse_m = since_ > 0 ? std::sqrt(squares_m2_ / static_cast<double>(since_)) : kUnknown;
  s.nees = mean_interval(nees_);
  s.searches_mean = s.trials > 0 ? searches_ / static_cast<double>(s.trials) : 0.0;
}

TrialSummary Tally::summary() const {
  TrialSummary s = sums_;
  add_rates(s);
  add_errors(s);
  s.localize_s = spread_of(localize_s_);
  s.notice_s = spread_of(notice_s_);
  s.step_ms = step_.spread_ms();
  s.search_ms = search_.spread_ms();
  s.calibration = calibration_.calibration();
  return s;
}

}  // namespace

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

TrialSummary summarise(const TrialPlan& plan, double limit_s, const ResultStream<TrialResult>& trials) {
  Tally tally(plan, limit_s);
  trials.each([&](const TrialResult& trial) { tally.add(trial); });
  return tally.summary();
}

}  // namespace parloc
