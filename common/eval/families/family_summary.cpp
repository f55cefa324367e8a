#include "common/eval/families/family_summary.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace parloc {
namespace {

bool soon(const std::optional<double>& after_s, double limit_s) {
  return after_s && *after_s <= limit_s + 1e-9;
}

/// One of the two runs of each drive. Means are over scans, not over drives, where not said otherwise.
class RunsTally {
 public:
  void add(const TrialResult& trial, const RunScore& score, double driven_s);
  RunsSummary summary() const;

 private:
  void count(const RunScore& score);

  std::size_t drives_ = 0, nearly_all_ = 0, all_ = 0, sure_wrong_1s_ = 0, localized_5s_ = 0, noticed_2s_ = 0;
  std::size_t late_ = 0, late_sure_wrong_ = 0;
  double scans_ = 0.0, within_ = 0.0, wrong_s_ = 0.0, driven_s_ = 0.0, largest_m_ = 0.0;
  std::array<double, 3> by_state_{};
  double x_error_m2_ = 0.0, sigma_x_m2_ = 0.0, searches_ = 0.0;
  std::vector<double> rmse_m_, nees_;  // as far as they are finite
  CalibrationTally calibration_;
};

void RunsTally::count(const RunScore& r) {
  ++drives_;
  nearly_all_ += r.within >= 0.99 ? 1 : 0;
  all_ += r.within >= 1.0 ? 1 : 0;
  sure_wrong_1s_ += r.longest_sure_wrong_s >= 1.0 ? 1 : 0;
  localized_5s_ += soon(r.localized_after_s, 5.0) ? 1 : 0;
  noticed_2s_ += soon(r.noticed_after_s, 2.0) ? 1 : 0;
  late_ += r.late;
  late_sure_wrong_ += r.late_sure_wrong;
}

void RunsTally::add(const TrialResult& trial, const RunScore& r, double driven_s) {
  count(r);
  const auto n = static_cast<double>(r.samples);
  scans_ += n;
  within_ += n * r.within;
  for (std::size_t k = 0; k < by_state_.size(); ++k) by_state_[k] += n * r.by_state[k];
  wrong_s_ += r.sure_wrong_s;
  driven_s_ += driven_s;
  for (const SampleMark mark : trial.marks) calibration_.add(mark);
  if (std::isfinite(r.rmse_m)) rmse_m_.push_back(r.rmse_m);
  if (std::isfinite(r.nees_mean)) nees_.push_back(r.nees_mean);
  largest_m_ = std::max(largest_m_, r.largest_m);
  x_error_m2_ += r.last_x_error_m * r.last_x_error_m;
  sigma_x_m2_ += r.last_sigma_x_m * r.last_sigma_x_m;
  searches_ += static_cast<double>(r.searches);
}

RunsSummary RunsTally::summary() const {
  RunsSummary s;
  const auto drives = static_cast<double>(drives_);
  s.nearly_all_within = wilson_rate(nearly_all_, drives_);
  s.all_within = wilson_rate(all_, drives_);
  s.sure_wrong_1s = wilson_rate(sure_wrong_1s_, drives_);
  s.localized_5s = wilson_rate(localized_5s_, drives_);
  s.noticed_2s = wilson_rate(noticed_2s_, drives_);
  s.within = within_ / scans_;
  for (std::size_t k = 0; k < by_state_.size(); ++k) s.by_state[k] = by_state_[k] / scans_;
  s.sure_wrong = wrong_s_ / driven_s_;
  s.late_sure_wrong = static_cast<double>(late_sure_wrong_) / static_cast<double>(late_);
  s.calibration = calibration_.calibration();
  s.calibration_error = expected_calibration_error(s.calibration);
  s.rmse_m = spread_of(rmse_m_);
  s.largest_m = largest_m_;
  s.nees = mean_interval(nees_);
  s.nees_median = spread_of(nees_).median;
  s.x_error_m = std::sqrt(x_error_m2_ / drives);
  s.sigma_x_m = std::sqrt(sigma_x_m2_ / drives);
  s.searches = searches_ / drives;
  return s;
}

class FamilyTally {
 public:
  explicit FamilyTally(std::string name) { sums_.family = std::move(name); }
  const std::string& name() const { return sums_.family; }

  void add(const DriveResult& d) {
    ++sums_.drives;
    sums_.scans += d.closed_score.samples;
    sums_.driven_s += d.driven_s;
    applies_ += d.comparison.applies ? 1 : 0;
    kept_ += d.comparison.kept ? 1 : 0;
    if (d.comparison.applies && !d.comparison.kept) sums_.failed.push_back(d.seed);
    closed_.add(d.closed, d.closed_score, d.driven_s);
    bare_.add(d.bare, d.bare_score, d.driven_s);
  }
  FamilySummary summary() const {
    FamilySummary s = sums_;
    s.kept = wilson_rate(kept_, applies_);
    s.closed = closed_.summary();
    s.bare = bare_.summary();
    return s;
  }

 private:
  FamilySummary sums_;  ///< What is a sum already.
  std::size_t applies_ = 0, kept_ = 0;
  RunsTally closed_, bare_;
};

}  // namespace

FamilySummaries summarise_families(const ResultStream<DriveResult>& drives) {
  FamilyTally all("all");
  std::vector<std::unique_ptr<FamilyTally>> families;
  drives.each([&](const DriveResult& d) {
    all.add(d);
    auto family =
        std::find_if(families.begin(), families.end(), [&](const auto& f) { return f->name() == d.family; });
    if (family == families.end())
      family = families.insert(families.end(), std::make_unique<FamilyTally>(d.family));
    (*family)->add(d);
  });
  FamilySummaries s;
  s.all = all.summary();
  for (const auto& family : families) s.families.push_back(family->summary());
  return s;
}

}  // namespace parloc
