// A Gaussian over poses, moved by odometry (SPEC 1.4).
#pragma once

#include "common/flow/pose_algebra.h"
#include "common/model/motion.h"

namespace parloc {

/// Grid frame; errors are added component by component, headings wrapped.
struct PoseGaussian {
  Vector3 mean;
  Matrix3 covariance;
};

/// The motion of a step in float64.
struct MotionNoise {
  double rot1, trans, rot2;
  Vector3 variance;  ///< Of the three; omni: of the way to the side, of the translation, of the rotation.
  bool omni = false;
  double spread_xy = 0.0, spread_theta = 0.0;  ///< Variances besides, whatever the motion.
};
PARLOC_HD MotionNoise motion_noise(const MotionStep& m) {
  MotionNoise n{m.rot1, m.trans, m.rot2, {}, m.omni != 0, 0.0, 0.0};
  const double s1 = n.omni ? m.sigma_strafe : m.sigma_rot1, st = m.sigma_trans, s2 = m.sigma_rot2;
  n.variance[0] = s1 * s1, n.variance[1] = st * st, n.variance[2] = s2 * s2;
  const double xy = m.spread_xy, theta = m.spread_theta;
  n.spread_xy = xy * xy, n.spread_theta = theta * theta;
  return n;
}

/// Where a pose goes without noise.
PARLOC_HD Vector3 moved(const Vector3& pose, const MotionNoise& u) {
  const SinCos64 a = portable_sincos64(pose[2] + u.rot1);
  Vector3 x;
  x[0] = pose[0] + u.trans * a.cos;
  x[1] = pose[1] + u.trans * a.sin;
  x[2] = wrap64(pose[2] + (u.rot1 + u.rot2));
  return x;
}

/// V: of the pose by (rot1, trans, rot2), or by (strafe, trans, rotation).
PARLOC_HD Matrix3 motion_jacobian(const Vector3& pose, const MotionNoise& u) {
  const SinCos64 a = portable_sincos64(pose[2] + u.rot1);
  Matrix3 v;
  v(0, 0) = u.omni ? a.sin : -u.trans * a.sin, v(0, 1) = a.cos;
  v(1, 0) = u.omni ? -a.cos : u.trans * a.cos, v(1, 1) = a.sin;
  v(2, 0) = u.omni ? 0.0 : 1.0, v(2, 2) = 1.0;
  return v;
}

/// V Q V^T: the covariance that one step adds.
PARLOC_HD Matrix3 motion_covariance(const Vector3& pose, const MotionNoise& u) {
  const Matrix3 v = motion_jacobian(pose, u);
  Matrix3 q = sandwich(v, diagonal3(u.variance[0], u.variance[1], u.variance[2]));
  q(0, 0) += u.spread_xy, q(1, 1) += u.spread_xy, q(2, 2) += u.spread_theta;
  return q;
}

PARLOC_HD PoseGaussian predicted(const PoseGaussian& g, const MotionNoise& u) {
  const SinCos64 a = portable_sincos64(g.mean[2] + u.rot1);
  Matrix3 by_pose = identity3();
  by_pose(0, 2) = -u.trans * a.sin;
  by_pose(1, 2) = u.trans * a.cos;
  PoseGaussian out;
  out.mean = moved(g.mean, u);
  out.covariance = sandwich(by_pose, g.covariance);
  const Matrix3 q = motion_covariance(g.mean, u);
  for (int i = 0; i < 9; ++i) out.covariance.m[i] += q.m[i];
  out.covariance = proper_covariance(out.covariance);
  return out;
}

}  // namespace parloc
