// Repeats a piece of work until its time is known well enough.
#pragma once

#include <functional>
#include <optional>

#include "tools/bench/steps/control.h"
#include "tools/report/machine/statistics.h"

namespace parloc::tools::bench {

/// Steps are counted until there are enough of them and they took long enough together, at most `most_steps`.
struct TimingRules {
  double seconds = 1.0;
  int least_steps = 5, most_steps = 5000;
  double long_seconds = 10.0;    ///< After so long 3 steps are enough, and one to warm up.
  int warm_up_steps = 2;         ///< At least; they are not counted.
  double warm_up_seconds = 0.1;  ///< And for at least as long.
};

/// The rules of --quick: rough, but soon done.
TimingRules quick_rules();

/// `step` does the work once and gives the seconds of the part that counts. Empty if asked to stop before the
/// end. After the deadline one step is enough (and one to warm up).
std::optional<TimeSummary> measure(const std::function<double()>& step, const TimingRules& rules,
                                   const Control& control);

}  // namespace parloc::tools::bench
