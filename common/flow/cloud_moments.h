// Mean and covariance of particles, with weights or without: terms of sums in the fixed shape
// (common/math/block_sum.h; SPEC 4).
#pragma once

#include "common/filter/moments.h"

namespace parloc {

constexpr int kCloudMeanSums = 4;        // x, y, sin, cos
constexpr int kCloudCovarianceSums = 6;  // xx, xy, xt, yy, yt, tt

/// The particles that sums run over. `weight` null: all weigh the same.
struct Cloud {
  Particles particles;
  const std::uint64_t* weight = nullptr;

  PARLOC_HD double weight_of(std::size_t i) const {
    return weight != nullptr ? static_cast<double>(weight[i]) : 1.0;
  }
  PARLOC_HD SumVector<kCloudMeanSums> mean_terms_of(std::size_t i) const {
    const Particles& p = particles;
    const double w = weight_of(i);
    const SinCos a = portable_sincos(p.theta[i]);
    return {{w * p.x[i], w * p.y[i], w * static_cast<double>(a.sin), w * static_cast<double>(a.cos)}};
  }
  PARLOC_HD SumVector<kCloudCovarianceSums> covariance_terms_of(std::size_t i, const Moments& m) const {
    const Particles& p = particles;
    const double w = weight_of(i);
    const double x = p.x[i] - m.x, y = p.y[i] - m.y, t = wrap64(p.theta[i] - m.theta);
    return {{w * (x * x), w * (x * y), w * (x * t), w * (y * y), w * (y * t), w * (t * t)}};
  }
};

}  // namespace parloc
