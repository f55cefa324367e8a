#include "tools/compare/run_all.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "common/config/pose_filters.h"
#include "common/error.h"
#include "common/eval/consistency.h"
#include "common/math/portable64.h"
#include "tools/program/run_items.h"
#include "tools/report/machine/statistics.h"

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
    const Clock::time_point begun = Clock::now();
    const Estimate e = filter.step(r.odometry, r.scan);
    const double took_s = seconds_since(begun);
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

bool SeedRuns::whole() const {
  return std::all_of(runs.begin(), runs.end(), [](const auto& run) { return run.has_value(); });
}

void run_all(const Request& request, const LogSource& source, const GridMap& map, const KeepSeed& keep) {
  std::atomic<std::size_t> finished = 0;
  const auto tell = [&] {
    const auto all = static_cast<double>(request.items.size() * request.entries.size());
    if (request.progress) request.progress(static_cast<double>(finished) / all, finished);
  };
  // Seed by seed, so that a log is made once for all filters; these are a thread's own.
  const auto make_worker = [&](std::size_t, const KeepGoing& keep_going) -> Worker {
    using Filters = std::vector<std::unique_ptr<PoseFilter>>;
    const auto filters = std::make_shared<Filters>(request.entries.size());
    return [&, filters, keep_going](std::size_t s) {
      const Clock::time_point begun = Clock::now();
      const std::uint64_t seed = request.first_seed + request.items[s];
      const TrialLog log = source.log_of(seed);
      SeedRuns of_seed{std::vector<std::optional<FilterRun>>(filters->size()),
                       std::vector<std::string>(filters->size()), log.hits, log.unmapped};
      for (std::size_t k = 0; k < filters->size() && keep_going(); ++k) {
        const Entry& entry = request.entries[k];
        auto& filter = (*filters)[k];
        if (!filter) filter = make_pose_filter(entry.kind, entry.config, map);
        of_seed.backends[k] = filter->backend_name();
        try {
          of_seed.runs[k] = follow(*filter, log, request.start, seed, keep_going);
        } catch (const Error& e) {
          throw Error(e.kind(), fmt::format("{}, seed {}: {}", entry.label, seed, e.what()));
        }
        if (of_seed.runs[k]) ++finished;
      }
      keep(request.items[s], seconds_since(begun), std::move(of_seed));
    };
  };
  run_items({request.items.size(), request.jobs, request.stop, tell}, make_worker);
}

Outcome outcome_of(std::size_t entries, const ResultStream<SeedRuns>& seeds) {
  Outcome outcome;
  outcome.runs.resize(entries);
  outcome.backends.resize(entries);
  seeds.each([&](const SeedRuns& of_seed) {
    for (std::size_t k = 0; k < entries; ++k) {
      if (!of_seed.backends[k].empty()) outcome.backends[k] = of_seed.backends[k];
      if (!of_seed.runs[k]) continue;
      outcome.runs[k].push_back(*of_seed.runs[k]);
      ++outcome.finished;
    }
    outcome.hits += of_seed.hits;
    outcome.unmapped += of_seed.unmapped;
  });
  return outcome;
}

}  // namespace parloc::tools::compare
