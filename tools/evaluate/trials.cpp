#include "tools/evaluate/trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/filter/filter_group.h"
#include "common/inputs/open_truth.h"
#include "common/simulator/wander.h"
#include "tools/program/run_items.h"
#include "tools/report/machine/statistics.h"

namespace parloc::tools::evaluate {
namespace {

constexpr double kClearance_m = 0.3;  // of the drives from walls

}  // namespace

LogSource simulated_trials(const TrialPlan& plan, const Scenario& scenario, const GridMap& map,
                           const std::string& name) {
  const WanderArea area(map, kClearance_m);
  const SimulatedLidar& l = scenario.lidar;
  return {[=](std::uint64_t seed) { return simulate_trial(plan, scenario, map, area, seed); },
          fmt::format("{}: random drives over {:.0f} m2 of {}; LiDAR {:.0f} degrees, {} beams, {:g} m", name,
                      area.area_m2(), scenario.map_path,
                      l.angle_step_rad * l.beams * 180.0 / 3.14159265358979, l.beams, l.range_max_m)};
}

LogSource recorded_trials(const RecordedPlan& plan) {
  const Trajectory truth = open_truth(plan.truth, plan.choice);
  std::size_t broken_lines = 0;
  const std::vector<LogRecord> records = read_whole_log(plan.log, plan.choice, broken_lines);
  std::vector<double> stamps;
  for (const LogRecord& r : records)
    if (is_scan(r)) stamps.push_back(r.stamp_s);
  const double first_s = stamps.front();
  const double span_s = *std::max_element(stamps.begin(), stamps.end()) - first_s;
  const auto known = truth_at(truth, stamps);
  if (std::none_of(known.begin(), known.end(), [](const auto& pose) { return pose.has_value(); }))
    throw input_error(plan.truth, 0, fmt::format("expected poses at the times of {}, found none", plan.log));

  const auto log_of = [=](std::uint64_t seed) {
    const double from_s = first_s + span_s * static_cast<double>(seed - 1) / static_cast<double>(plan.starts);
    const auto begins = [&](const LogRecord& r) { return is_scan(r) && r.stamp_s >= from_s; };
    const auto begin = std::find_if(records.begin(), records.end(), begins);
    TrialLog log;
    log.truth = truth;
    const double until_s = begin->stamp_s + plan.duration_s;
    for (auto record = begin; record != records.end(); ++record) {
      if (plan.duration_s > 0.0 && record->stamp_s > until_s) break;
      log.records.push_back(*record);
    }
    return log;
  };
  return {log_of, fmt::format("{}: {} starts spread over {:.0f} s", plan.log, plan.starts, span_s)};
}

double run_trials(const TrialsRequest& request, const LogSource& source, const GridMap& map,
                  const KeepTrial& keep) {
  std::vector<LocalizerConfig> configs{request.config};
  if (request.other) configs.emplace_back(*request.other);
  for (LocalizerConfig& config : configs) {
    config.threads = 1;
    if (request.jobs > 1) config.group = make_filter_group(config);
  }
  const std::size_t runs = request.items.size() * configs.size();
  std::vector<std::atomic<double>> fractions(
      static_cast<std::size_t>(request.jobs));  // of each thread's trial
  std::atomic<std::size_t> finished = 0;
  std::atomic<double> took_s = 0.0;  // all together
  const auto tell = [&] {
    if (!request.progress) return;
    double done = static_cast<double>(finished);
    for (const std::atomic<double>& fraction : fractions) done += fraction;
    request.progress(done / static_cast<double>(runs), finished / configs.size());
  };
  const auto make_worker = [&](std::size_t thread, const KeepGoing& keep_going) -> Worker {
    std::vector<std::shared_ptr<Localizer>> localizers;
    for (const LocalizerConfig& config : configs)
      localizers.push_back(std::make_shared<Localizer>(config, map));
    return [&, thread, localizers](std::size_t k) {
      const std::size_t item = request.items[k / configs.size()], which = k % configs.size();
      const std::uint64_t seed = request.first_seed + item;
      const auto told = [&](double fraction) {
        fractions[thread] = fraction;
        return keep_going();
      };
      const Clock::time_point begun = Clock::now();
      std::optional<TrialResult> result =
          run_trial(*localizers[which], request.plan, source.log_of(seed), seed, told);
      fractions[thread] = 0.0;
      if (!result) return;
      if (!request.samples) result->samples = {};
      const double run_s = seconds_since(begun);
      keep(item * configs.size() + which, run_s, std::move(*result));
      took_s += run_s;
      ++finished;
    };
  };
  run_items({runs, request.jobs, request.stop, tell}, make_worker);
  return took_s * static_cast<double>(configs.size()) / static_cast<double>(finished);
}

std::vector<TrialResult> run_trials(const TrialsRequest& request, const LogSource& source, const GridMap& map,
                                    double* trial_s) {
  std::map<std::size_t, TrialResult> results;
  std::mutex mutex;
  const double mean_s = run_trials(request, source, map, [&](std::size_t item, double, TrialResult result) {
    const std::lock_guard lock(mutex);
    results.emplace(item, std::move(result));
  });
  if (trial_s != nullptr) *trial_s = mean_s;
  std::vector<TrialResult> all;
  for (auto& [item, result] : results) all.push_back(std::move(result));
  return all;
}

}  // namespace parloc::tools::evaluate
