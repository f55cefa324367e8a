#include "common/eval/families/drive_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace parloc {
namespace {

constexpr double kNear_m = 0.5;
constexpr double kSettled_s = 10.0;  // in which a filter may find out what it is about
constexpr double kMostRatio = 1.1, kMostMore_m = 0.1;

}  // namespace

RunScore score_run(const TrialResult& trial) {
  RunScore score;
  const TrialPlan rule;  // 0.5 m and 10 degrees
  double squares_m2 = 0.0, within = 0.0;
  for (const TrialSample& s : trial.samples) {
    squares_m2 += s.position_error_m * s.position_error_m;
    score.largest_m = std::max(score.largest_m, s.position_error_m);
    score.largest_rad = std::max(score.largest_rad, s.heading_error_rad);
    within += s.position_error_m <= kNear_m ? 1.0 : 0.0;
    score.by_state[static_cast<std::size_t>(s.state)] += 1.0;
    if (s.stamp_s < trial.begun_s + kSettled_s) continue;
    ++score.late;
    score.late_sure_wrong += s.state == HealthState::tracking && !is_right(rule, s) ? 1 : 0;
  }
  const auto n = static_cast<double>(trial.samples.size());
  score.samples = trial.samples.size();
  score.rmse_m = std::sqrt(squares_m2 / n);
  score.within = within / n;
  for (double& share : score.by_state) share /= n;
  score.sure_wrong_s = trial.outcome.missed_lost_s;
  score.longest_sure_wrong_s = trial.outcome.confident_wrong_s;
  score.nees_mean = trial.outcome.nees_sum / static_cast<double>(trial.outcome.nees_count);
  score.searches = trial.searches;
  score.localized_after_s = trial.outcome.localized_after_s;
  score.noticed_after_s = trial.outcome.noticed_after_s;
  if (trial.samples.empty()) return score;
  score.last_x_error_m = trial.samples.back().x_error_m;
  score.last_sigma_x_m = trial.samples.back().sigma_x_m;
  return score;
}

Comparison compare_runs(const RunScore& closed, const RunScore& bare) {
  Comparison c;
  c.applies = bare.samples > 0 && bare.largest_m <= kNear_m;
  c.kept = c.applies && closed.rmse_m <= kMostRatio * bare.rmse_m &&
           closed.largest_m <= bare.largest_m + kMostMore_m;
  return c;
}

}  // namespace parloc
