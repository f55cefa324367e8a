// Many trials at once, of simulated drives or parts of a recorded log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/eval/run_trial.h"
#include "common/eval/trial.h"
#include "common/io/log_choice.h"
#include "common/localize/localizer.h"
#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"
#include "tools/program/run_items.h"

namespace parloc::tools::evaluate {

/// A random drive per seed through `map`. Throws Error{input} for a map without room to drive.
LogSource simulated_trials(const TrialPlan& plan, const Scenario& scenario, const GridMap& map,
                           const std::string& name);

struct RecordedPlan {
  std::string log, truth;  ///< Files.
  std::size_t starts = 20;
  double duration_s = 0.0;  ///< 0: to the end of the log.
  LogChoice choice{};       ///< Of a bag.
};

/// Seed k, from 1 to `starts`, is the log from its kth start time on; these are spread evenly, the first one
/// at the first scan. Reads both files: throws Error{input} as their readers, for a log without a scan, and
/// for a truth of another time.
LogSource recorded_trials(const RecordedPlan& plan);

struct TrialsRequest {
  TrialPlan plan;
  Config config;  ///< Its numbers of threads do not count: each localizer has one.
  std::uint64_t first_seed = 1;
  std::vector<std::size_t> items;  ///< Which trials: item k has the seed first_seed + k.
  int jobs = 1;
  bool samples = false;        ///< Whether results keep them; marks they always have.
  std::function<bool()> stop;  ///< Asked often; may be empty.
  /// Told now and then, on the caller's thread; may be empty.
  std::function<void(double fraction, std::size_t finished)> progress;
  /// With it each trial is done twice, as item 2 k with `config` and as 2 k + 1 with this.
  std::optional<Config> other{};
};

/// Told of each finished trial, by any thread.
using KeepTrial = std::function<void(std::size_t item, double took_s, TrialResult result)>;

/// The first error of any trial, or of `keep`, ends the work and is thrown. Gives the mean time of a trial
/// [s], by `other` too if there is one; NaN if none was finished.
double run_trials(const TrialsRequest& request, const LogSource& source, const GridMap& map,
                  const KeepTrial& keep);
/// The finished trials in the order of the items, whatever the number of jobs; all, unless `stop` said so.
/// `trial_s`, if given, becomes their mean time.
std::vector<TrialResult> run_trials(const TrialsRequest& request, const LogSource& source, const GridMap& map,
                                    double* trial_s = nullptr);

}  // namespace parloc::tools::evaluate
