#include "common/eval/trial.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/simulator/drive.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

/// Boxes stand along a path: a shorter one has fewer of them, as dense as the scenario has them on its own.
int boxes_along(const WaypointPath& path, const Scenario& base) {
  const double own_m = path_length_m(base.path);
  if (!(own_m > 0.0)) return base.clutter.boxes;
  return static_cast<int>(std::lround(base.clutter.boxes * path_length_m(path) / own_m));
}

/// The scenario's robot on a random drive.
Scenario random_drive(const TrialPlan& plan, const Scenario& base, const WanderArea& area,
                      std::uint64_t seed) {
  Scenario scenario = base;
  scenario.path = area.wander(plan.duration_s, plan.speed_mps, plan.turn_rate_rad_s, seed);
  scenario.clutter.boxes = boxes_along(scenario.path, base);
  scenario.seed = seed;
  return scenario;
}

/// The log and truth of a drive.
SimulatedLog simulate_until(const Scenario& scenario, const GridMap& map, double duration_s) {
  SimulatedLog log = simulate(scenario, map, [&](double) { return true; });
  const auto late = [&](double stamp_s) { return stamp_s > duration_s; };
  std::erase_if(log.records, [&](const LogRecord& r) { return late(r.stamp_s); });
  std::erase_if(log.truth, [&](const StampedPose& p) { return late(p.stamp_s); });
  return log;
}

/// The stamp of the first sample from which on it is right for `hold_s`, or to the end if that comes first.
std::optional<double> right_from(const TrialPlan& plan, const std::vector<TrialSample>& samples,
                                 double since_s) {
  std::optional<double> from;
  for (const TrialSample& s : samples) {
    if (s.stamp_s < since_s) continue;
    if (!is_right(plan, s)) {
      from.reset();
    } else if (!from) {
      from = s.stamp_s;
    }
    if (from && s.stamp_s - *from >= plan.hold_s - 1e-9) return from;
  }
  return from;
}

}  // namespace

TrialLog simulate_drives(std::vector<Scenario> drives, const GridMap& map, double duration_s) {
  TrialLog log;
  for (Scenario& drive : drives) {
    double shift_s = 0.0;
    if (!log.records.empty()) {
      drive.odometry.start = log.records.back().odometry;
      shift_s = log.truth.back().stamp_s + 1.0 / drive.scan_rate_hz;
      log.kidnapped_s = shift_s;
    }
    SimulatedLog part = simulate_until(drive, map, duration_s);
    for (LogRecord& record : part.records) {
      record.stamp_s += shift_s;
      record.scan.stamp_s += shift_s;
      log.records.push_back(std::move(record));
    }
    for (const StampedPose& pose : part.truth) log.truth.push_back({pose.stamp_s + shift_s, pose.pose});
    log.hits += part.hits;
    log.unmapped += part.unmapped;
  }
  return log;
}

TrialLog simulate_trial(const TrialPlan& plan, const Scenario& scenario, const GridMap& map,
                        const WanderArea& area, std::uint64_t seed) {
  std::vector<Scenario> drives{random_drive(plan, scenario, area, 2 * seed)};
  if (plan.task == TrialTask::kidnap) drives.push_back(random_drive(plan, scenario, area, 2 * seed + 1));
  return simulate_drives(std::move(drives), map, plan.duration_s);
}

bool is_right(const TrialPlan& plan, const TrialSample& s) {
  return s.position_error_m < plan.near_m && s.heading_error_rad < plan.near_rad;
}

TrialOutcome judge_trial(const TrialPlan& plan, const std::vector<TrialSample>& samples, double since_s) {
  TrialOutcome outcome;
  const std::optional<double> from = right_from(plan, samples, since_s);
  if (from) outcome.localized_after_s = *from - since_s;
  std::optional<double> wrong_since_s;
  bool was_lost = plan.task == TrialTask::global;  // before the first scan nobody can know
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const TrialSample& s = samples[k];
    const double lasts_s = k + 1 < samples.size() ? std::max(0.0, samples[k + 1].stamp_s - s.stamp_s) : 0.0;
    const bool right = is_right(plan, s), tracking = s.state == HealthState::tracking;
    const bool lost = s.state == HealthState::lost;
    ++outcome.samples;
    outcome.right += right ? 1 : 0;
    (right ? outcome.right_s : outcome.wrong_s) += lasts_s;
    if (tracking && !right) outcome.missed_lost_s += lasts_s;
    if (s.stamp_s < since_s) outcome.tracked_before = right && tracking;
    if (s.stamp_s >= since_s && !tracking && !outcome.noticed_after_s)
      outcome.noticed_after_s = s.stamp_s - since_s;
    if (right && lost && !was_lost) ++outcome.false_lost;
    was_lost = lost;
    const bool grace =
        plan.task == TrialTask::kidnap && s.stamp_s >= since_s && s.stamp_s < since_s + plan.grace_s;
    if (tracking && !right && !grace) {
      ++outcome.confident_wrong;
      if (!wrong_since_s) wrong_since_s = s.stamp_s;
      outcome.confident_wrong_s = std::max(outcome.confident_wrong_s, s.stamp_s - *wrong_since_s);
    } else {
      wrong_since_s.reset();
    }
    if (!from || s.stamp_s < *from) continue;
    ++outcome.since_localized;
    outcome.wrong_since += right ? 0 : 1;
    outcome.squared_error_m2 += s.position_error_m * s.position_error_m;
    if (!std::isfinite(s.nees)) continue;  // a covariance that is none
    ++outcome.nees_count;
    outcome.nees_sum += s.nees;
  }
  return outcome;
}

}  // namespace parloc
