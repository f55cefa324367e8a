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

PARLOC_EVERY_CASE
MotionStep motion_step(const OdometryIncrement& d, const MotionConfig& c, double inflation) {
  const double n1 = magnitude(d.rot1_rad, c.symmetric);
  const double n2 = magnitude(d.rot2_rad, c.symmetric);
  const double t = __builtin_fabs(d.trans_m);
  double s1 = 0.0, st = 0.0, s2 = 0.0;
  switch (c.form) {
    case MotionForm::seed:
      s1 = c.alpha1 * n1 + c.alpha2 * t;
      st = c.alpha3 * t + c.alpha4 * (n1 + n2);
      s2 = c.alpha1 * n2 + c.alpha2 * t;
      break;
    case MotionForm::thrun:
      s1 = __builtin_sqrt(c.alpha1 * n1 * n1 + c.alpha2 * t * t);
      st = __builtin_sqrt(c.alpha3 * t * t + c.alpha4 * (n1 * n1 + n2 * n2));
      s2 = __builtin_sqrt(c.alpha1 * n2 * n2 + c.alpha2 * t * t);
      break;
  }
  const bool moves = t > 0.0 || n1 > 0.0 || n2 > 0.0;
  const double floor_rot = moves ? c.sigma_rot_min_rad : 0.0;
  const double floor_trans = moves ? c.sigma_trans_min_m : 0.0;
  return {static_cast<float>(d.rot1_rad),
          static_cast<float>(d.trans_m),
          static_cast<float>(d.rot2_rad),
          static_cast<float>(inflation * larger(s1, floor_rot)),
          static_cast<float>(inflation * larger(st, floor_trans)),
          static_cast<float>(inflation * larger(s2, floor_rot))};
}
PARLOC_EVERY_CASE_END

}  // namespace parloc
