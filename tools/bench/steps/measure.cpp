#include "tools/bench/steps/measure.h"

#include <algorithm>
#include <cmath>
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

std::optional<Bracket> largest_that_fits(std::int64_t least, std::int64_t most, std::int64_t guess,
                                         double tolerance,
                                         const std::function<std::optional<bool>(std::int64_t)>& fits) {
  Bracket b;
  std::int64_t next = std::clamp(guess, least, most);
  for (;;) {
    const std::optional<bool> answer = fits(next);
    if (!answer) return std::nullopt;
    (*answer ? b.fits : b.too_many) = next;
    if (b.fits == most || b.too_many == least) return b;
    if (b.fits == 0) {
      next = std::max(least, b.too_many / 2);
    } else if (b.too_many == 0) {
      next = std::min(most, 2 * b.fits);
    } else {
      if (static_cast<double>(b.too_many) <= (1.0 + tolerance) * static_cast<double>(b.fits)) return b;
      if (b.too_many - b.fits <= 1) return b;
      const double middle = std::sqrt(static_cast<double>(b.fits) * static_cast<double>(b.too_many));
      next = std::clamp(static_cast<std::int64_t>(middle), b.fits + 1, b.too_many - 1);
    }
  }
}

}  // namespace parloc::tools::bench
