#include "tools/compare/follow.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/error.h"
#include "common/eval/consistency.h"
#include "common/math/portable64.h"

namespace parloc::tools::compare {
namespace {

/// The circle's part between the directions of two seeds in a row: no two of them are ever near each other.
constexpr double kGoldenAngle_rad = 2.39996322972865332;

bool is_near(double error_m) {
  return error_m <= kLost_m;  // not a number is not near
}

/// From the first scan until it was near for good, or, with `near` false, until it never was again; nothing
/// if it ended otherwise.
std::optional<double> for_good_s(const TrackErrors& e, bool near) {
  std::optional<double> since_s;
  for (std::size_t k = 0; k < e.compared; ++k) {
    if (is_near(e.position_error_m[k]) != near)
      since_s.reset();
    else if (!since_s)
      since_s = e.stamp_s[k] - e.stamp_s[0];
  }
  return since_s;
}

double share_away(const TrackErrors& e) {
  const auto near = std::count_if(e.position_error_m.begin(), e.position_error_m.end(), is_near);
  return 1.0 - static_cast<double>(near) / static_cast<double>(e.compared);
}

void judge(FilterRun& run, const Trajectory& track, const std::vector<StampedCovariance>& covariances,
           const Trajectory& truth) {
  run.errors = compare_tracks(track, truth);
  run.nees = check_consistency(run.errors, covariances).nees_mean;
  run.final_m = run.errors.position_error_m.back();
  run.found_s = for_good_s(run.errors, true);
  run.lost_s = for_good_s(run.errors, false);
  run.away = share_away(run.errors);
  run.particles /= static_cast<double>(run.scans);
  run.driven_s = track.back().stamp_s - track.front().stamp_s;
}

}  // namespace

Pose told_start(const StartPlan& plan, const Pose& truth, std::uint64_t seed) {
  const SinCos64 direction = portable_sincos64(wrap64(kGoldenAngle_rad * static_cast<double>(seed)));
  const double turn_rad = seed % 2 == 1 ? plan.off_rad : -plan.off_rad;
  return {truth.x_m + plan.off_m * direction.cos, truth.y_m + plan.off_m * direction.sin,
          wrap64(truth.theta_rad + turn_rad)};
}

std::optional<FilterRun> follow(PoseFilter& filter, const TrialLog& log, const StartPlan& start,
                                std::uint64_t seed, const std::function<bool()>& keep_going) {
  const auto truth = truth_at(log.truth, {log.records.empty() ? 0.0 : log.records.front().stamp_s});
  if (log.records.empty() || !truth[0])
    throw Error(ErrorKind::input, "expected a log that begins with a scan whose true pose is known");
  FilterRun run;
  run.seed = seed;
  Trajectory track;
  std::vector<StampedCovariance> covariances;
  filter.set_seed(seed);
  filter.start_at(told_start(start, *truth[0], seed), start.sigma_xy_m, start.sigma_xy_m,
                  start.sigma_theta_rad);
  for (const LogRecord& r : log.records) {
    filter.add_odometry(r.stamp_s, r.odometry);
    if (r.kind != RecordKind::scan) continue;
    const auto begun = std::chrono::steady_clock::now();
    const Estimate e = filter.step(r.odometry, r.scan);
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    const bool first = run.scans++ == 0;
    if (!first) run.working_s += took_s;
    if (!first && e.weighted) run.step_s.push_back(took_s);
    run.skipped += e.weighted ? 0 : 1;
    run.particles += static_cast<double>(e.particles);
    track.push_back({r.stamp_s, e.pose});
    covariances.push_back({r.stamp_s, e.covariance});
    if (keep_going && !keep_going()) return std::nullopt;
  }
  judge(run, track, covariances, log.truth);
  return run;
}

}  // namespace parloc::tools::compare
