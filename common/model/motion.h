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

/// A step as the odometry tells it.
struct Movement {
  OdometryIncrement increment;
  double elapsed_s = 0.0;  ///< How long it took, as far as known.
  bool guessed = false;    ///< The odometry jumped: this is how the robot had been moving before.
};

/// An increment with its standard deviations: what the predict stage gets, by value.
struct MotionStep {
  float rot1 = 0, trans = 0, rot2 = 0;
  float sigma_rot1 = 0, sigma_trans = 0, sigma_rot2 = 0;
  float sigma_strafe = 0;                 ///< omni: to the side of the way that it went; rot1 is its bearing.
  float spread_xy = 0, spread_theta = 0;  ///< Noise besides, whatever the motion: widens a lost cloud.
  float slip_xy = 0, slip_theta = 0;      ///< Noise besides of every slip_every-th particle.
  std::uint32_t slip_every = 0;           ///< 0: of none.
  std::uint32_t omni = 0;                 ///< Whether it is that form.
};

/// Of differential wheels a step shorter than min_translation_m is a turn in place, and what it says to the
/// side is left out. SPEC 1.1.
OdometryIncrement odometry_increment(const Pose& previous, const Pose& current, double min_translation_m);
/// Where that leads to from `previous`: `current`, but for what was left out.
Pose moved(const Pose& previous, const OdometryIncrement& increment);

/// Standard deviations of the chosen form (SPEC 1.2, 1.5) with the floors. A guessed motion is as uncertain
/// as it is long.
MotionStep motion_step(const Movement& movement, const MotionConfig& config);
inline MotionStep motion_step(const OdometryIncrement& increment, const MotionConfig& config) {
  return motion_step(Movement{increment}, config);
}

/// A particle's noise: block 0 of stream `motion` (SPEC 1.3).
PARLOC_HD Normals motion_noise(std::uint32_t slot, std::uint32_t step, std::uint64_t seed) {
  return normals(philox(slot, step, Stream::motion, 0, seed));
}

/// The motion of differential wheels: words of the noise -> rot1, trans, rot2 (SPEC 1.3).
PARLOC_HD void predict_differential(float& x, float& y, float& theta, const MotionStep& m, const Normals& n) {
  const float rot1 = fused(m.sigma_rot1, n.n[0], m.rot1);
  const float trans = fused(m.sigma_trans, n.n[1], m.trans);
  const float rot2 = fused(m.sigma_rot2, n.n[2], m.rot2);
  const SinCos a = portable_sincos(theta + rot1);
  x = fused(trans, a.cos, x);
  y = fused(trans, a.sin, y);
  theta = wrap(theta + (rot1 + rot2));
}

/// The omnidirectional motion (SPEC 1.5): words -> translation, rotation, sideways.
PARLOC_HD void predict_omni(float& x, float& y, float& theta, const MotionStep& m, const Normals& n) {
  const float trans = fused(m.sigma_trans, n.n[0], m.trans);
  const float turn = fused(m.sigma_rot2, n.n[1], m.rot1 + m.rot2);
  const float strafe = m.sigma_strafe * n.n[2];
  const SinCos a = portable_sincos(theta + m.rot1);
  x = fused(strafe, a.sin, fused(trans, a.cos, x));
  y = fused(-strafe, a.cos, fused(trans, a.sin, y));
  theta = wrap(theta + turn);
}

/// Moves one particle in the step's form.
PARLOC_HD void predict_one(float& x, float& y, float& theta, const MotionStep& m, std::uint32_t slot,
                           std::uint32_t step, std::uint64_t seed) {
  const Normals n = motion_noise(slot, step, seed);
  if (m.omni != 0) return predict_omni(x, y, theta, m, n);
  predict_differential(x, y, theta, m, n);
}

PARLOC_HD bool widens(const MotionStep& m) {
  return m.spread_xy > 0.0f || m.spread_theta > 0.0f;
}

/// Whether this particle is one of those that slip: the slots after resampling go through the cloud in
/// order, so that every so manieth of them is a fair sample of it.
PARLOC_HD bool slips(const MotionStep& m, std::uint32_t slot, std::uint32_t step) {
  return m.slip_every > 0 && (slot + step) % m.slip_every == 0;
}

/// Noise besides the motion's own, from a block of stream `motion`: words -> x, y, theta.
PARLOC_HD void add_noise(float& x, float& y, float& theta, float sigma_xy, float sigma_theta,
                         const Normals& n) {
  x = fused(sigma_xy, n.n[0], x);
  y = fused(sigma_xy, n.n[1], y);
  theta = wrap(fused(sigma_theta, n.n[2], theta));
}

/// Adds the noise that widens the cloud: block 1.
PARLOC_HD void spread_one(float& x, float& y, float& theta, const MotionStep& m, std::uint32_t slot,
                          std::uint32_t step, std::uint64_t seed) {
  add_noise(x, y, theta, m.spread_xy, m.spread_theta, normals(philox(slot, step, Stream::motion, 1, seed)));
}

/// And that of a slip: block 2.
PARLOC_HD void slip_one(float& x, float& y, float& theta, const MotionStep& m, std::uint32_t slot,
                        std::uint32_t step, std::uint64_t seed) {
  add_noise(x, y, theta, m.slip_xy, m.slip_theta, normals(philox(slot, step, Stream::motion, 2, seed)));
}

}  // namespace parloc
