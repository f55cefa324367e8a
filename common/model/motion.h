// Odometry motion model: rotate, translate, rotate, each with Gaussian noise (Paz et al. 2012 eq. 6 to 8;
// SPEC 1).
#pragma once

#include <cstdint>

#include "common/math/philox.h"
#include "common/math/pose.h"
#include "common/model/motion_config.h"

namespace parloc {

/// The odometry between two poses, in the frame of the first (SPEC 1.1).
struct OdometryIncrement {
  double rot1_rad = 0.0;
  double trans_m = 0.0;  ///< Negative for a short step backwards.
  double rot2_rad = 0.0;
};

/// An increment with its standard deviations: what the predict stage gets, by value.
struct MotionStep {
  float rot1 = 0, trans = 0, rot2 = 0;
  float sigma_rot1 = 0, sigma_trans = 0, sigma_rot2 = 0;
  float spread_xy = 0, spread_theta = 0;  ///< Noise besides, whatever the motion: widens a lost cloud.
};

OdometryIncrement odometry_increment(const Pose& previous, const Pose& current, double min_translation_m);

/// Standard deviations of the chosen form (SPEC 1.2). inflation scales all of them (1: as configured).
MotionStep motion_step(const OdometryIncrement& increment, const MotionConfig& config,
                       double inflation = 1.0);

/// Moves one particle: noise from stream `motion`, words -> rot1, trans, rot2 (SPEC 1.3).
PARLOC_HD void predict_one(float& x, float& y, float& theta, const MotionStep& m, std::uint32_t slot,
                           std::uint32_t step, std::uint64_t seed) {
  const Normals n = normals(philox(slot, step, Stream::motion, 0, seed));
  const float rot1 = fused(m.sigma_rot1, n.n[0], m.rot1);
  const float trans = fused(m.sigma_trans, n.n[1], m.trans);
  const float rot2 = fused(m.sigma_rot2, n.n[2], m.rot2);
  const SinCos a = portable_sincos(theta + rot1);
  x = fused(trans, a.cos, x);
  y = fused(trans, a.sin, y);
  theta = wrap(theta + (rot1 + rot2));
}

PARLOC_HD bool widens(const MotionStep& m) {
  return m.spread_xy > 0.0f || m.spread_theta > 0.0f;
}

/// Adds the noise that widens the cloud: block 1 of stream `motion`, words -> x, y, theta.
PARLOC_HD void spread_one(float& x, float& y, float& theta, const MotionStep& m, std::uint32_t slot,
                          std::uint32_t step, std::uint64_t seed) {
  const Normals n = normals(philox(slot, step, Stream::motion, 1, seed));
  x = fused(m.spread_xy, n.n[0], x);
  y = fused(m.spread_xy, n.n[1], y);
  theta = wrap(fused(m.spread_theta, n.n[2], theta));
}

}  // namespace parloc
