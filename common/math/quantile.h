// Quantiles of values in ascending order, none of them NaN. Of no values each is NaN.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace parloc {

/// `values` in ascending order.
inline std::vector<double> ascending(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values;
}

/// The smallest value that `percent` (1 to 100) % of them are at or below.
inline double nearest_rank(const std::vector<double>& sorted, std::size_t percent) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  return sorted[(percent * sorted.size() + 99) / 100 - 1];
}

/// Linear between the two nearest order statistics, of which the first has the share 0 and the last 1.
inline double interpolated_quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// The mean of the middle two of an even count.
inline double median(const std::vector<double>& sorted) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t n = sorted.size();
  return n % 2 == 1 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
}

/// The larger of the middle two of an even count.
inline double upper_median(const std::vector<double>& sorted) {
  return sorted.empty() ? std::numeric_limits<double>::quiet_NaN() : sorted[sorted.size() / 2];
}

}  // namespace parloc
