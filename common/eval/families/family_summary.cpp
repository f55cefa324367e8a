#include "common/eval/families/family_summary.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace parloc {
namespace {

using Drives = std::vector<const DriveResult*>;

/// One of the two runs of a drive.
struct Side {
  TrialResult DriveResult::*trial;
  RunScore DriveResult::*score;
};
constexpr Side kClosed{&DriveResult::closed, &DriveResult::closed_score};
constexpr Side kBare{&DriveResult::bare, &DriveResult::bare_score};

template <class Holds>
Rate rate_of(const Drives& drives, Side side, Holds holds) {
  const auto hits = std::count_if(drives.begin(), drives.end(),
                                  [&](const DriveResult* d) { return holds(d->*side.score); });
  return wilson_rate(static_cast<std::size_t>(hits), drives.size());
}

bool soon(const std::optional<double>& after_s, double limit_s) {
  return after_s && *after_s <= limit_s + 1e-9;
}

void add_rates(const Drives& drives, Side side, RunsSummary& s) {
  s.nearly_all_within = rate_of(drives, side, [](const RunScore& r) { return r.within >= 0.99; });
  s.all_within = rate_of(drives, side, [](const RunScore& r) { return r.within >= 1.0; });
  s.sure_wrong_1s = rate_of(drives, side, [](const RunScore& r) { return r.longest_sure_wrong_s >= 1.0; });
  s.localized_5s = rate_of(drives, side, [](const RunScore& r) { return soon(r.localized_after_s, 5.0); });
  s.noticed_2s = rate_of(drives, side, [](const RunScore& r) { return soon(r.noticed_after_s, 2.0); });
}

/// Means over scans, not over drives.
void add_scans(const Drives& drives, Side side, RunsSummary& s) {
  const TrialPlan rule;  // 0.5 m and 10 degrees
  double scans = 0.0, wrong_s = 0.0, driven_s = 0.0, late = 0.0, late_wrong = 0.0;
  std::vector<Forecast> forecasts;
  for (const DriveResult* d : drives) {
    const RunScore& r = d->*side.score;
    const auto n = static_cast<double>(r.samples);
    scans += n;
    s.within += n * r.within;
    for (std::size_t k = 0; k < s.by_state.size(); ++k) s.by_state[k] += n * r.by_state[k];
    wrong_s += r.sure_wrong_s;
    driven_s += d->driven_s;
    for (const TrialSample& sample : (d->*side.trial).samples) {
      forecasts.push_back({sample.probability, is_right(rule, sample)});
      if (sample.stamp_s < (d->*side.trial).begun_s + 10.0) continue;
      late += 1.0;
      late_wrong += sample.state == HealthState::tracking && !is_right(rule, sample) ? 1.0 : 0.0;
    }
  }
  s.within /= scans;
  for (double& share : s.by_state) share /= scans;
  s.sure_wrong = wrong_s / driven_s;
  s.late_sure_wrong = late_wrong / late;
  s.calibration = check_calibration(forecasts);
  s.calibration_error = expected_calibration_error(s.calibration);
}

void add_errors(const Drives& drives, Side side, RunsSummary& s) {
  std::vector<double> rmse_m, nees;
  double error_m2 = 0.0, sigma_m2 = 0.0;
  for (const DriveResult* d : drives) {
    const RunScore& r = d->*side.score;
    if (std::isfinite(r.rmse_m)) rmse_m.push_back(r.rmse_m);
    if (std::isfinite(r.nees_mean)) nees.push_back(r.nees_mean);
    s.largest_m = std::max(s.largest_m, r.largest_m);
    error_m2 += r.last_x_error_m * r.last_x_error_m;
    sigma_m2 += r.last_sigma_x_m * r.last_sigma_x_m;
    s.searches += static_cast<double>(r.searches) / static_cast<double>(drives.size());
  }
  s.rmse_m = spread_of(std::move(rmse_m));
  s.nees = mean_interval(nees);
  s.nees_median = spread_of(std::move(nees)).median;
  s.x_error_m = std::sqrt(error_m2 / static_cast<double>(drives.size()));
  s.sigma_x_m = std::sqrt(sigma_m2 / static_cast<double>(drives.size()));
}

RunsSummary summarise_runs(const Drives& drives, Side side) {
  RunsSummary s;
  add_rates(drives, side, s);
  add_scans(drives, side, s);
  add_errors(drives, side, s);
  return s;
}

FamilySummary summarise(const std::string& name, const Drives& drives) {
  FamilySummary s;
  s.family = name;
  s.drives = drives.size();
  std::size_t applies = 0, kept = 0;
  for (const DriveResult* d : drives) {
    s.scans += d->closed_score.samples;
    s.driven_s += d->driven_s;
    applies += d->comparison.applies ? 1 : 0;
    kept += d->comparison.kept ? 1 : 0;
    if (d->comparison.applies && !d->comparison.kept) s.failed.push_back(d->seed);
  }
  s.kept = wilson_rate(kept, applies);
  s.closed = summarise_runs(drives, kClosed);
  s.bare = summarise_runs(drives, kBare);
  return s;
}

}  // namespace

std::vector<FamilySummary> summarise_families(const std::vector<DriveResult>& drives) {
  std::vector<std::pair<std::string, Drives>> families;
  for (const DriveResult& d : drives) {
    auto family =
        std::find_if(families.begin(), families.end(), [&](const auto& f) { return f.first == d.family; });
    if (family == families.end()) family = families.insert(families.end(), {d.family, {}});
    family->second.push_back(&d);
  }
  std::vector<FamilySummary> summaries;
  for (const auto& [name, members] : families) summaries.push_back(summarise(name, members));
  return summaries;
}

FamilySummary summarise_all(const std::vector<DriveResult>& drives) {
  Drives all;
  for (const DriveResult& d : drives) all.push_back(&d);
  return summarise("all", all);
}

}  // namespace parloc
