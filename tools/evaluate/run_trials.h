// Many trials at once: one localizer per thread, whole trials as the unit of work.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/config/config.h"
#include "common/eval/run_trial.h"
#include "common/localize/localizer.h"
#include "tools/evaluate/trial_source.h"

namespace parloc::tools::evaluate {

struct TrialsRequest {
  TrialPlan plan;
  Config config;  ///< Its numbers of threads do not count: each localizer has one.
  std::uint64_t first_seed = 1;
  std::size_t trials = 1;
  int jobs = 1;
  std::function<bool()> stop;  ///< Asked often; may be empty.
  /// Told now and then, on the caller's thread; may be empty.
  std::function<void(double fraction, std::size_t finished)> progress;
};

/// The finished trials in the order of their seeds, whatever the number of jobs; all, unless `stop` said so.
/// The first error of any trial ends the work and is thrown.
std::vector<TrialResult> run_trials(const TrialsRequest& request, const TrialSource& source,
                                    const GridMap& map);

}  // namespace parloc::tools::evaluate
