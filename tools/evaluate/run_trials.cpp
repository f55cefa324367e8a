#include "tools/evaluate/run_trials.h"

#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "tools/program/run_items.h"

namespace parloc::tools::evaluate {

std::vector<TrialResult> run_trials(const TrialsRequest& request, const TrialSource& source,
                                    const GridMap& map) {
  LocalizerConfig config = request.config;
  config.threads = 1;
  std::vector<std::optional<TrialResult>> results(
      request.trials);  // each written by the one thread that has it
  std::vector<std::atomic<double>> fractions(
      static_cast<std::size_t>(request.jobs));  // of each thread's trial
  std::atomic<std::size_t> finished = 0;
  const auto tell = [&] {
    if (!request.progress) return;
    double done = static_cast<double>(finished);
    for (const std::atomic<double>& fraction : fractions) done += fraction;
    request.progress(done / static_cast<double>(request.trials), finished);
  };
  const auto make_worker = [&](std::size_t thread, const KeepGoing& keep_going) -> Worker {
    const auto localizer = std::make_shared<Localizer>(config, map);
    return [&, thread, localizer](std::size_t k) {
      const std::uint64_t seed = request.first_seed + k;
      const auto told = [&](double fraction) {
        fractions[thread] = fraction;
        return keep_going();
      };
      results[k] = run_trial(*localizer, request.plan, source.trial(seed), seed, told);
      fractions[thread] = 0.0;
      if (results[k]) ++finished;
    };
  };
  run_items({request.trials, request.jobs, request.stop, tell}, make_worker);
  std::vector<TrialResult> all;
  for (std::optional<TrialResult>& result : results)
    if (result) all.push_back(std::move(*result));
  return all;
}

}  // namespace parloc::tools::evaluate
