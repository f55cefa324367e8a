// Repeats a piece of work until its time is known well enough, and finds the largest that fits in a time.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "tools/report/machine/statistics.h"

namespace parloc::tools::bench {

/// How a measurement is told to end early, and tells how far it is. All members may be empty.
struct Control {
  std::function<bool()> stop;                              ///< True: end now, keep what is done.
  std::function<void(double, std::string_view)> progress;  ///< Fraction of the work, and what is done now.
  std::optional<Clock::time_point> deadline;               ///< What has not begun by then is skipped.

  bool stopped() const { return stop && stop(); }
  bool out_of_time() const { return deadline && Clock::now() >= *deadline; }
  void tell(double fraction, std::string_view what) const {
    if (progress) progress(fraction, what);
  }
};

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

struct Bracket {
  std::int64_t fits = 0;      ///< The largest that was found to fit; 0: none was.
  std::int64_t too_many = 0;  ///< The smallest that was found not to fit; 0: none was.
};

/// Of sizes from `least` to `most`: doubles or halves from `guess` until one fits and one does not, then
/// halves the distance (geometrically) until it is within `tolerance` (0.03: 3 %). `fits` gives empty to end
/// the search; then the answer is empty too.
std::optional<Bracket> largest_that_fits(std::int64_t least, std::int64_t most, std::int64_t guess,
                                         double tolerance,
                                         const std::function<std::optional<bool>(std::int64_t)>& fits);

}  // namespace parloc::tools::bench
