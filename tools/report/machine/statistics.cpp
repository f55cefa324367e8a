#include "tools/report/machine/statistics.h"

#include <algorithm>
#include <cmath>

namespace parloc::tools {
namespace {

/// Linear between the two nearest of the sorted values.
double quantile(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

TimeSummary summarise_times(std::vector<double> seconds) {
  if (seconds.empty()) return {};
  std::sort(seconds.begin(), seconds.end());
  const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(seconds.size())));
  return {seconds.size(),          quantile(seconds, 0.5), seconds[rank - 1], quantile(seconds, 0.25),
          quantile(seconds, 0.75), seconds.front(),        seconds.back()};
}

}  // namespace parloc::tools
