// How long a work took, and what many times of the same work say.
#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

namespace parloc::tools {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct TimeSummary {
  std::size_t count = 0;
  double median_s = 0.0;          ///< The mean of the middle two of an even count.
  double p99_s = 0.0;             ///< Nearest rank: of fewer than 100 times, the longest.
  double q1_s = 0.0, q3_s = 0.0;  ///< Quartiles, linear between the two nearest times.
  double least_s = 0.0, most_s = 0.0;
};

/// All zero of no times at all.
TimeSummary summarise_times(std::vector<double> seconds);

}  // namespace parloc::tools
