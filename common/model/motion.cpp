#include "common/model/motion.h"

#include "common/math/portable64.h"

namespace parloc {
namespace {

double magnitude(double rotation_rad, bool symmetric) {
  const double forward = __builtin_fabs(wrap64(rotation_rad));
  if (!symmetric) return forward;
  const double backward = __builtin_fabs(wrap64(rotation_rad - kPi));
  return forward < backward ? forward : backward;
}

double larger(double a, double b) {
  return a > b ? a : b;
}

}  // namespace

OdometryIncrement odometry_increment(const Pose& previous, const Pose& current, double min_translation_m) {
  const double dx = current.x_m - previous.x_m;
  const double dy = current.y_m - previous.y_m;
  const double turn = wrap64(current.theta_rad - previous.theta_rad);
  const double trans = __builtin_sqrt(dx * dx + dy * dy);
  if (trans < min_translation_m) {  // a turn in place: atan2 of jitter would be noise
    const SinCos64 h = portable_sincos64(previous.theta_rad);
    return {0.0, dx * h.cos + dy * h.sin, turn};
  }
  const double rot1 = wrap64(portable_atan2_64(dy, dx) - previous.theta_rad);
  return {rot1, trans, wrap64(turn - rot1)};
}

Pose moved(const Pose& previous, const OdometryIncrement& d) {
  const SinCos64 a = portable_sincos64(previous.theta_rad + d.rot1_rad);
  return {previous.x_m + d.trans_m * a.cos, previous.y_m + d.trans_m * a.sin,
          wrap64(previous.theta_rad + (d.rot1_rad + d.rot2_rad))};
}

namespace {

/// Standard deviations of one step.
struct Sigmas {
  double rot1 = 0.0, trans = 0.0, rot2 = 0.0, strafe = 0.0;
};

double root_of_squares(double a, double b) {
  return __builtin_sqrt(a * a + b * b);
}

PARLOC_EVERY_CASE
Sigmas sigmas_of(const OdometryIncrement& d, const MotionConfig& c) {
  const double n1 = magnitude(d.rot1_rad, c.symmetric);
  const double n2 = magnitude(d.rot2_rad, c.symmetric);
  const double t = __builtin_fabs(d.trans_m);
  switch (c.form) {
    case MotionForm::seed:
      return {c.alpha1 * n1 + c.alpha2 * t, c.alpha3 * t + c.alpha4 * (n1 + n2),
              c.alpha1 * n2 + c.alpha2 * t};
    case MotionForm::thrun:
      return {__builtin_sqrt(c.alpha1 * n1 * n1 + c.alpha2 * t * t),
              __builtin_sqrt(c.alpha3 * t * t + c.alpha4 * (n1 * n1 + n2 * n2)),
              __builtin_sqrt(c.alpha1 * n2 * n2 + c.alpha2 * t * t)};
    case MotionForm::omni: {
      const double turn = wrap64(d.rot1_rad + d.rot2_rad);
      return {0.0, __builtin_sqrt(c.alpha3 * t * t + c.alpha4 * turn * turn),
              __builtin_sqrt(c.alpha1 * turn * turn + c.alpha2 * t * t),
              __builtin_sqrt(c.alpha4 * turn * turn + c.alpha5 * t * t)};
    }
  }
  return {};
}
PARLOC_EVERY_CASE_END

}  // namespace

MotionStep motion_step(const Movement& movement, const MotionConfig& c) {
  const OdometryIncrement& d = movement.increment;
  const bool omni = c.form == MotionForm::omni;
  Sigmas s = sigmas_of(d, c);
  const bool moves = d.trans_m != 0.0 || d.rot1_rad != 0.0 || d.rot2_rad != 0.0;
  if (moves) {
    if (!omni) s.rot1 = larger(s.rot1, c.sigma_rot_min_rad);
    s.rot2 = larger(s.rot2, c.sigma_rot_min_rad);
    s.trans = larger(s.trans, c.sigma_trans_min_m);
  }
  if (movement.elapsed_s > 0.0) {
    const double root_s = __builtin_sqrt(movement.elapsed_s);
    s.rot2 = root_of_squares(s.rot2, c.sigma_rot_per_s * root_s);
    s.trans = root_of_squares(s.trans, c.sigma_trans_per_s * root_s);
    if (omni) s.strafe = root_of_squares(s.strafe, c.sigma_trans_per_s * root_s);
  }
  MotionStep step{.rot1 = static_cast<float>(d.rot1_rad),
                  .trans = static_cast<float>(d.trans_m),
                  .rot2 = static_cast<float>(d.rot2_rad),
                  .sigma_rot1 = static_cast<float>(s.rot1),
                  .sigma_trans = static_cast<float>(s.trans),
                  .sigma_rot2 = static_cast<float>(s.rot2),
                  .sigma_strafe = static_cast<float>(s.strafe),
                  .omni = omni ? 1u : 0u};
  if (movement.guessed) {
    constexpr double kGuess_m = 0.1, kGuess_rad = 0.05;  // of a robot that stood, too
    const double turn = __builtin_fabs(wrap64(d.rot1_rad + d.rot2_rad));
    step.spread_xy = static_cast<float>(0.5 * __builtin_fabs(d.trans_m) + kGuess_m);
    step.spread_theta = static_cast<float>(0.5 * turn + kGuess_rad);
  }
  if (c.slip_share > 0.0) {
    step.slip_every = static_cast<std::uint32_t>(__builtin_floor(1.0 / c.slip_share + 0.5));
    step.slip_xy = static_cast<float>(c.slip_sigma_m);
    step.slip_theta = static_cast<float>(c.slip_sigma_rad);
  }
  return step;
}

}  // namespace parloc
