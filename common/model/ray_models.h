// Log-likelihood of one measured range given the expected one (SPEC 3.1, 3.3). Pure functions;
// particle-independent constants are left out. Hits and misses are separate functions because a beam table
// holds them apart. `constant` is what a model knows of the beam besides its range.
#pragma once

#include "common/math/host_device.h"
#include "common/math/portable.h"
#include "common/model/sensor_config.h"

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

/// SPEC 3.3, mode s5: the density if both ranges are within the maximum, the tail of the Gaussian beyond the
/// difference to the maximum if one is, and a constant if both are beyond. It mixes a density and a
/// probability for the same observation; `beam` does not.
struct S5Beam {
  float minus_half_inv_variance;  // [1/m^2]
  float inv_sigma;
  float log_peak;  // log(1 / (sigma sqrt(2 pi)))
  float log_epsilon;
  float range_max_m;

  PARLOC_HD float hit(float measured_m, float, float expected_m) const {
    const float d = measured_m - expected_m;
    const float density = fused(minus_half_inv_variance, d * d, log_peak);
    return expected_m < range_max_m ? density : tail_from(measured_m);
  }
  PARLOC_HD float miss(float, float expected_m) const {
    return expected_m < range_max_m ? tail_from(expected_m) : log_epsilon;
  }
  PARLOC_HD float most_of_hit(float measured_m, float) const {
    return max_of(log_peak, tail_from(measured_m));
  }
  PARLOC_HD float most_of_miss() const { return max_of(-0.6931f, log_epsilon); }  // half of it lies beyond

  PARLOC_HD float tail_from(float range_m) const {
    return portable_log_upper_tail(max_of(range_max_m - range_m, 0.0f) * inv_sigma);
  }
};

/// The censored beam mixture: a measured hit is a density for every particle, a measured miss a probability
/// for every particle (Probabilistic Robotics table 6.1 with the Gaussian's tail beyond the maximum moved to
/// the miss). `constant` is z_short lambda exp(-lambda measured).
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
    const float short_mass = 1.0f - quick_exp(-lambda * max_of(expected_m, 1e-3f));
    const float seen_wall = hit_peak * quick_exp(-0.5f * (g * g)) + rand_density;
    const float in_front = measured_m <= expected_m ? short_density / short_mass : 0.0f;
    const float seen_nothing = short_density * inv_short_mass_max + rand_density;
    return quick_log(expected_m < range_max_m ? seen_wall + in_front : seen_nothing);
  }
  PARLOC_HD float miss(float, float expected_m) const {
    const float tail = 0.5f * quick_erfc((range_max_m - expected_m) * inv_sigma * 0.707106781f);
    return quick_log(z_hit * (expected_m < range_max_m ? tail : 1.0f) + z_max);
  }
  /// Upper bounds of hit and miss over all expected ranges, with room for the rounding of exp and log.
  PARLOC_HD float most_of_hit(float measured_m, float short_density) const {
    const float short_mass = 1.0f - quick_exp(-lambda * max_of(measured_m, 1e-3f));
    return quick_log(hit_peak + rand_density + short_density / short_mass) + 1e-4f;
  }
  PARLOC_HD float most_of_miss() const { return quick_log(z_hit + z_max) + 1e-4f; }
};

/// A beam as seen by a whole cloud of particles: the map's part of the censored mixture, raised to how
/// probable it is that this beam saw the map at all. That is one unknown per beam, the same for all
/// particles, so that none of them gains by taking a person for a wall; beam_votes finds it
/// (common/filter/beam_votes.h). `constant` is that share.
struct ClassConditionalBeam {
  CensoredBeam mixture;

  /// Density of a measured range if the beam saw the map.
  PARLOC_HD float map_density(float measured_m, float expected_m) const {
    const float g = (measured_m - expected_m) * mixture.inv_sigma;
    const float seen_wall = mixture.hit_peak * quick_exp(-0.5f * (g * g)) + mixture.rand_density;
    return expected_m < mixture.range_max_m ? seen_wall : mixture.rand_density;
  }
  /// And if something in front of the map stopped it.
  PARLOC_HD float unmapped_density(float measured_m, float short_density, float expected_m) const {
    const float short_mass = 1.0f - quick_exp(-mixture.lambda * max_of(expected_m, 1e-3f));
    return measured_m <= expected_m ? short_density / short_mass : 0.0f;
  }

  PARLOC_HD float hit(float measured_m, float share, float expected_m) const {
    return share * quick_log(map_density(measured_m, expected_m));
  }
  PARLOC_HD float miss(float measured_m, float expected_m) const {
    return mixture.miss(measured_m, expected_m);
  }
  PARLOC_HD float most_of_hit(float, float share) const {
    return share * (quick_log(mixture.hit_peak + mixture.rand_density) + 1e-4f);
  }
  PARLOC_HD float most_of_miss() const { return mixture.most_of_miss(); }
};

inline GaussianBeam bind_gaussian(const SensorConfig& c) {
  return {static_cast<float>(-0.5 / (c.sigma_hit * c.sigma_hit))};
}

inline S5Beam bind_s5(const SensorConfig& c, float range_max_m) {
  return {static_cast<float>(-0.5 / (c.sigma_hit * c.sigma_hit)), static_cast<float>(1.0 / c.sigma_hit),
          portable_log(static_cast<float>(0.39894228040143267794 / c.sigma_hit)),
          portable_log(static_cast<float>(c.s5_epsilon)), range_max_m};
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
          1.0f / (1.0f - quick_exp(-lambda * range_max_m))};
}

/// All of them, bound for one scan.
struct RayModels {
  GaussianBeam gaussian;
  S5Beam s5;
  CensoredBeam censored;
};

inline RayModels bind_ray_models(const SensorConfig& c, float range_max_m) {
  return {bind_gaussian(c), bind_s5(c, range_max_m), bind_censored(c, range_max_m)};
}

PARLOC_EVERY_CASE
/// use(the model chosen). The one list of the models that cast rays.
template <class Use>
PARLOC_HD auto with_ray_model(const RayModels& models, SensorModel chosen, const Use& use) {
  switch (chosen) {
    case SensorModel::gaussian:
      return use(models.gaussian);
    case SensorModel::s5:
      return use(models.s5);
    case SensorModel::class_conditional:
      return use(ClassConditionalBeam{models.censored});
    case SensorModel::beam:
      return use(models.censored);
    case SensorModel::likelihood_field:
    case SensorModel::likelihood_field_prob:
      break;  // They cast no rays, so nobody asks.
  }
  return use(models.censored);
}
PARLOC_EVERY_CASE_END

}  // namespace parloc
