// The Kalman update with one innovation per beam, in information form, iterated (SPEC 8.2): Gauss-Newton scan
// matching to the distance field, with the motion as prior.
#pragma once

#include "common/flow/field_measurement.h"
#include "common/flow/pose_gaussian.h"

namespace parloc {

/// One iteration about `at`. Not ok: nothing can be said, and nothing changes.
struct InformationStep {
  Vector3 step;        ///< From `at`.
  Matrix3 covariance;  ///< Of the posterior, if this was the last.
  bool ok = false;
};
PARLOC_HD InformationStep information_step(const PoseGaussian& prior, const Vector3& at,
                                           const ScanInformation& scan) {
  InformationStep out;
  const Cholesky3 of_prior = cholesky(prior.covariance);
  if (!of_prior.ok) return out;
  const Matrix3 known = inverse(of_prior);
  Matrix3 information;
  for (int i = 0; i < 9; ++i) information.m[i] = known.m[i] + scan.matrix.m[i];
  Cholesky3 c = cholesky(information);
  if (!c.ok) {  // rounding: a trifle more certain everywhere
    for (int i = 0; i < 3; ++i) information(i, i) *= 1.0 + 1e-9;
    c = cholesky(information);
    if (!c.ok) return out;
  }
  const Vector3 back = multiply(known, box_minus(prior.mean, at));
  out.step = solve(c, plus(back, 1.0, scan.vector));
  out.covariance = proper_covariance(inverse(c));
  out.ok = true;
  return out;
}

/// Too short to go on.
PARLOC_HD bool has_converged(const Vector3& step) {
  double most = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double size = __builtin_fabs(step[i]);
    if (size > most) most = size;
  }
  return most < 1e-5;
}

}  // namespace parloc
