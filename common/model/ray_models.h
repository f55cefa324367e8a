// Log-likelihood of one measured range given the expected one (SPEC 3.1, 3.3). Pure functions;
// particle-independent constants are left out. Hits and misses are separate functions because a beam table
// holds them apart.
#pragma once

#include "common/filter/config.h"
#include "common/math/portable.h"

namespace parloc {

/// Paz et al. 2012 eq. 11, one factor: Gaussian about the expected range; both sides clamped to the maximum
/// range.
struct GaussianBeam {
  float minus_half_inv_variance;  // [1/m^2]

  PARLOC_HD float hit(float measured_m, float, float expected_m) const {
    const float d = measured_m - expected_m;
    return minus_half_inv_variance * (d * d);
  }
  PARLOC_HD float miss(float measured_m, float expected_m) const { return hit(measured_m, 0.0f, expected_m); }
  /// Upper bounds of hit and miss over all expected ranges.
  PARLOC_HD float most_of_hit(float, float) const { return 0.0f; }
  PARLOC_HD float most_of_miss() const { return 0.0f; }
};

/// The censored beam mixture: a measured hit is a density for every particle, a measured miss a probability
/// for every particle (Probabilistic Robotics table 6.1 with the Gaussian's tail beyond the maximum moved to
/// the miss).
struct CensoredBeam {
  float inv_sigma;
  float hit_peak;  // z_hit / (sigma sqrt(2 pi))
  float z_hit, z_max;
  float rand_density;  // z_rand / range_max
  float lambda;
  float range_max_m;
  float inv_short_mass_max;  // 1 / (1 - exp(-lambda range_max))

  PARLOC_HD float hit(float measured_m, float short_density, float expected_m) const {
    const float g = (measured_m - expected_m) * inv_sigma;
    const float short_mass = 1.0f - portable_exp(-lambda * max_of(expected_m, 1e-3f));
    const float seen_wall = fused(hit_peak, portable_exp(-0.5f * (g * g)), rand_density);
    const float in_front = measured_m <= expected_m ? short_density / short_mass : 0.0f;
    const float seen_nothing = fused(short_density, inv_short_mass_max, rand_density);
    return portable_log(expected_m < range_max_m ? seen_wall + in_front : seen_nothing);
  }
  PARLOC_HD float miss(float, float expected_m) const {
    const float tail = 0.5f * portable_erfc((range_max_m - expected_m) * inv_sigma * 0.707106781f);
    return portable_log(fused(z_hit, expected_m < range_max_m ? tail : 1.0f, z_max));
  }
  /// Upper bounds of hit and miss over all expected ranges, with room for the rounding of exp and log.
  PARLOC_HD float most_of_hit(float measured_m, float short_density) const {
    const float short_mass = 1.0f - portable_exp(-lambda * max_of(measured_m, 1e-3f));
    return portable_log(hit_peak + rand_density + short_density / short_mass) + 1e-4f;
  }
  PARLOC_HD float most_of_miss() const { return portable_log(z_hit + z_max) + 1e-4f; }
};

inline GaussianBeam bind_gaussian(const SensorConfig& c) {
  return {static_cast<float>(-0.5 / (c.sigma_hit * c.sigma_hit))};
}

inline CensoredBeam bind_censored(const SensorConfig& c, float range_max_m) {
  const float lambda = static_cast<float>(c.lambda_short);
  return {static_cast<float>(1.0 / c.sigma_hit),
          static_cast<float>(c.z_hit * 0.39894228040143267794 / c.sigma_hit),
          static_cast<float>(c.z_hit),
          static_cast<float>(c.z_max),
          static_cast<float>(c.z_rand) / range_max_m,
          lambda,
          range_max_m,
          1.0f / (1.0f - portable_exp(-lambda * range_max_m))};
}

}  // namespace parloc
