#include "common/eval/consistency.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/quantile.h"

namespace parloc {

namespace {

/// Added to every variance: what a collapsed particle set is taken to know at best.
constexpr double kLeastVariance = 1e-8;

}  // namespace

// P = L L', so that e' P^-1 e is the square of the solution of L z = e.
double normalised_error_squared(const Covariance& covariance, double x_m, double y_m, double heading_rad) {
  const double* p = covariance.v;
  const double a = std::sqrt(p[0] + kLeastVariance), b = p[1] / a, c = p[2] / a;
  const double d = std::sqrt(p[4] + kLeastVariance - b * b), e = (p[5] - b * c) / d;
  const double f = std::sqrt(p[8] + kLeastVariance - c * c - e * e);
  const double z0 = x_m / a, z1 = (y_m - b * z0) / d, z2 = (heading_rad - c * z0 - e * z1) / f;
  const double square = z0 * z0 + z1 * z1 + z2 * z2;
  return std::isfinite(square) ? square : std::numeric_limits<double>::quiet_NaN();
}

Consistency check_consistency(const TrackErrors& errors, const std::vector<StampedCovariance>& covariances) {
  constexpr double kChiSquare95 = 7.814727903251179;
  Consistency c;
  double sum = 0, x_sum = 0, y_sum = 0, heading_sum = 0;
  std::size_t within = 0, j = 0;
  for (const StampedCovariance& row : covariances) {
    if (j == errors.stamp_s.size()) break;
    if (errors.stamp_s[j] != row.stamp_s) continue;  // had no truth
    const double x_m = errors.x_error_m[j], y_m = errors.y_error_m[j],
                 heading_rad = errors.heading_error_rad[j];
    ++j;
    const double nees = normalised_error_squared(row.covariance, x_m, y_m, heading_rad);
    if (std::isnan(nees)) {
      ++c.singular;
      continue;
    }
    c.nees.push_back(nees);
    within += nees < kChiSquare95 ? 1 : 0;
    sum += nees;
    x_sum += x_m * x_m / (row.covariance.v[0] + kLeastVariance);
    y_sum += y_m * y_m / (row.covariance.v[4] + kLeastVariance);
    heading_sum += heading_rad * heading_rad / (row.covariance.v[8] + kLeastVariance);
  }
  c.compared = c.nees.size();
  const double n = static_cast<double>(c.compared);  // none: 0 / 0 is NaN, as it should be
  c.nees_mean = sum / n;
  c.nees_median = upper_median(ascending(c.nees));
  c.within_95 = static_cast<double>(within) / n;
  c.x_mean = x_sum / n;
  c.y_mean = y_sum / n;
  c.heading_mean = heading_sum / n;
  return c;
}

}  // namespace parloc
