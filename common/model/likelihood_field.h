// The likelihood field (Thrun, Burgard & Fox, Probabilistic Robotics table 6.3; SPEC 3.4): a beam's
// log-likelihood is a look-up at its end point, from a table over the map made once.
#pragma once

#include <cstdint>
#include <vector>

#include "common/filter/config.h"
#include "common/map/grid_map.h"
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

/// log p(D) - log p(0) for a squared distance in cells. log_relative(0) is 0.
float field_log_likelihood(std::uint32_t squared_cells, double resolution_m, double range_max_m,
                           const SensorConfig& config);

/// The padded table ((width + 2) x (height + 2)) from squared distances [cells^2], row-major width x height.
std::vector<float> likelihood_table(const std::vector<std::uint32_t>& squared_cells, const GridMap& map,
                                    double range_max_m, const SensorConfig& config);

}  // namespace parloc
