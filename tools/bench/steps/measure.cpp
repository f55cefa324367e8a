#include "tools/bench/steps/measure.h"

#include <utility>
#include <vector>

namespace parloc::tools::bench {
namespace {

constexpr int kFewSteps = 3;

/// False if asked to stop.
bool warm_up(const std::function<double()>& step, const TimingRules& rules, const Control& control) {
  const Clock::time_point begun = Clock::now();
  for (int k = 0; k < rules.warm_up_steps || seconds_since(begun) < rules.warm_up_seconds; ++k) {
    if (control.stopped()) return false;
    if (k > 0 && (control.out_of_time() || seconds_since(begun) >= rules.long_seconds)) break;
    step();
  }
  return true;
}

}  // namespace

TimingRules quick_rules() {
  TimingRules rules;
  rules.seconds = 0.05;
  rules.least_steps = 2;
  rules.warm_up_steps = 1;
  rules.warm_up_seconds = 0.02;
  return rules;
}

std::optional<TimeSummary> measure(const std::function<double()>& step, const TimingRules& rules,
                                   const Control& control) {
  if (!warm_up(step, rules, control)) return std::nullopt;
  std::vector<double> seconds;
  const Clock::time_point begun = Clock::now();
  for (int k = 0; k < rules.most_steps; ++k) {
    const double elapsed_s = seconds_since(begun);
    if (k >= rules.least_steps && elapsed_s >= rules.seconds) break;
    if (k >= kFewSteps && elapsed_s >= rules.long_seconds) break;
    if (k > 0 && control.out_of_time()) break;
    if (control.stopped()) return std::nullopt;
    seconds.push_back(step());
  }
  return summarise_times(std::move(seconds));
}

}  // namespace parloc::tools::bench
