#include "tools/report/machine/statistics.h"

#include <utility>

#include "common/math/quantile.h"

namespace parloc::tools {

TimeSummary summarise_times(std::vector<double> seconds) {
  if (seconds.empty()) return {};
  const std::vector<double> sorted = ascending(std::move(seconds));
  return {sorted.size(),
          interpolated_quantile(sorted, 0.5),
          nearest_rank(sorted, 99),
          interpolated_quantile(sorted, 0.25),
          interpolated_quantile(sorted, 0.75),
          sorted.front(),
          sorted.back()};
}

}  // namespace parloc::tools
