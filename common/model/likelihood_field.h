// The likelihood field (Thrun, Burgard & Fox, Probabilistic Robotics table 6.3; SPEC 3.4): a beam's
// log-likelihood is a look-up at its end point, from a table over the map made once.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/filter/config.h"
#include "common/math/portable.h"

namespace parloc {

/// Log-likelihood of an end point by cell: log p(D) - log p(0), 0 on a wall, least beyond the distance cap.
/// `values` points at cell (0, 0) of a padded array whose ring holds the value of "off the map".
struct LikelihoodField {
  const float* values = nullptr;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t stride = 0;

  /// Value of the cell that the end point (u, v) [cells] lies in.
  PARLOC_HD float nearest(float u, float v) const {
    const float cu = floor_of(min_of(max_of(u, -1.0f), static_cast<float>(width)));
    const float cv = floor_of(min_of(max_of(v, -1.0f), static_cast<float>(height)));
    return values[static_cast<std::int32_t>(cv) * stride + static_cast<std::int32_t>(cu)];
  }

  /// Interpolated between the four cell centres around the end point.
  PARLOC_HD float bilinear(float u, float v) const {
    const float cu = min_of(max_of(u - 0.5f, -1.0f), static_cast<float>(width));
    const float cv = min_of(max_of(v - 0.5f, -1.0f), static_cast<float>(height));
    const float fu = min_of(floor_of(cu), static_cast<float>(width - 1));
    const float fv = min_of(floor_of(cv), static_cast<float>(height - 1));
    const float a = cu - fu;
    const float b = cv - fv;
    const std::int32_t at = static_cast<std::int32_t>(fv) * stride + static_cast<std::int32_t>(fu);
    const float low = fused(a, values[at + 1] - values[at], values[at]);
    const float high = fused(a, values[at + stride + 1] - values[at + stride], values[at + stride]);
    return fused(b, high - low, low);
  }
};

/// log p(D) - log p(0) of a squared distance in cells: 0 on a wall, least from the distance cap on.
struct DistanceLikelihood {
  double squared_cell_m2;
  double squared_cap_m2;
  double variance_m2;
  float peak, floor;  // densities: of a hit on a wall, and of anything [1/m]
  float log_at_wall;

  PARLOC_HD float operator()(std::uint32_t squared_cells) const {
    const double squared_m2 = squared_cell_m2 * static_cast<double>(squared_cells);
    const double capped_m2 = squared_m2 < squared_cap_m2 ? squared_m2 : squared_cap_m2;
    const float exponent = static_cast<float>(-0.5 * capped_m2 / variance_m2);
    return portable_log(fused(peak, portable_exp(exponent), floor)) - log_at_wall;
  }
};

inline DistanceLikelihood bind_distance(const SensorConfig& c, double resolution_m, double range_max_m) {
  const double cap_m = c.laser_likelihood_max_dist;
  const float peak = static_cast<float>(c.z_hit * 0.39894228040143267794 / c.sigma_hit);
  const float floor = static_cast<float>(c.z_rand / range_max_m);
  return {resolution_m * resolution_m, cap_m * cap_m, c.sigma_hit * c.sigma_hit, peak, floor,
          portable_log(peak + floor)};
}

/// Value of cell `at` of the padded table ((width + 2) x (height + 2), row-major), whose ring is off the map.
/// squared_cells: width x height, row-major, squared distance to the nearest wall [cells^2].
PARLOC_HD float table_value(const DistanceLikelihood& likelihood, const std::uint32_t* squared_cells,
                            std::int32_t width, std::int32_t height, std::size_t at) {
  const std::size_t stride = static_cast<std::size_t>(width) + 2;
  const std::size_t i = at % stride, j = at / stride;
  const bool on_map = i >= 1 && i + 1 < stride && j >= 1 && j <= static_cast<std::size_t>(height);
  return likelihood(on_map ? squared_cells[(j - 1) * static_cast<std::size_t>(width) + (i - 1)]
                           : 0xffffffffu);
}

}  // namespace parloc
