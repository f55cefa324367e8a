// Whether a filter's covariance says how far off it is (Bar-Shalom, Li & Kirubarajan 2001, section 5.4).
#pragma once

#include <cstddef>
#include <vector>

#include "common/eval/metrics.h"
#include "common/filter/particle_filter.h"

namespace parloc {

/// A covariance and when it held.
struct StampedCovariance {
  double stamp_s = 0.0;
  Covariance covariance;
};

/// Normalised estimation error squared: e' P^-1 e of the error e in x, y, heading. A filter that knows itself
/// has 3 on average; more: it is over-confident.
struct Consistency {
  std::size_t compared = 0;
  std::size_t singular = 0;  ///< Steps whose covariance is not one: no inverse even with 1e-8 added.
  double nees_mean = 0, nees_median = 0;
  double within_95 = 0;  ///< Share of the steps below 7.81, the 95 % point of chi-square with 3 degrees.
  double x_mean = 0, y_mean = 0, heading_mean = 0;  ///< Of each alone: 1 is right.
  std::vector<double> nees;                         ///< Per compared step.
};

/// Pairs errors and covariances by equal stamps, both in the order of the run. All NaN if there are none.
Consistency check_consistency(const TrackErrors& errors, const std::vector<StampedCovariance>& covariances);

/// e' (P + 1e-8 I)^-1 e: a collapsed particle set has a singular P (SPEC 4). NaN if even that is not positive
/// definite.
double normalised_error_squared(const Covariance& covariance, double x_m, double y_m, double heading_rad);

}  // namespace parloc
