// How a measurement is told to end early, and tells how far it is.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string_view>

namespace parloc::tools::bench {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// All members may be empty.
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

}  // namespace parloc::tools::bench
