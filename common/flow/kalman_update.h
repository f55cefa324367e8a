// Kalman updates on the distance field: with one innovation per scan, 0 - psi (Dantanarayana et al. 2013;
// SPEC 8.1, 8.3), and with one per beam.
#pragma once

#include "common/flow/field_measurement.h"
#include "common/flow/pose_gaussian.h"

namespace parloc {

/// How far off a scan may be before it is mistrusted.
struct GateRule {
  FlowGate kind = FlowGate::off;
  double most_nis = 0.0;
};

struct GatedNoise {
  double variance = 0.0;  ///< r, larger if the scan was mistrusted.
  double nis = 0.0;       ///< psi^2 / S before that.
  bool rejected = false;
};
PARLOC_HD GatedNoise gate(const Matrix3& covariance, const FieldMeasurement& z, double variance,
                          const GateRule& rule) {
  const double s = dot(z.slope, multiply(covariance, z.slope));
  GatedNoise g{variance, z.psi_m * z.psi_m / (s + variance), false};
  if (rule.kind == FlowGate::off || g.nis <= rule.most_nis) return g;
  g.rejected = rule.kind == FlowGate::reject;
  g.variance = variance * (g.nis / rule.most_nis);
  return g;
}

/// The variance with which a scan moves its end points, in the root mean square, by `most_m` at most: at
/// least `variance`. Where walls of all directions pull, their slopes cancel out and the distances do not,
/// and the step would be many times as long as the field holds.
PARLOC_HD double short_step_variance(const Matrix3& covariance, const FieldMeasurement& z, double variance,
                                     double most_m) {
  const Vector3 k = multiply(covariance, z.slope);
  const double shift = __builtin_sqrt(k[0] * k[0] + k[1] * k[1]) + __builtin_fabs(k[2]) * z.arm_m;
  const double s = dot(z.slope, k), least = z.pull_m * shift / most_m - s;
  return least > variance ? least : variance;
}

/// Joseph form: symmetric and positive whatever the rounding.
PARLOC_HD PoseGaussian kalman_update(const PoseGaussian& prior, const FieldMeasurement& z, double variance) {
  const Vector3 k = multiply(prior.covariance, z.slope);
  const double innovation_variance = dot(z.slope, k) + variance;
  Vector3 gain;
  for (int i = 0; i < 3; ++i) gain[i] = k[i] / innovation_variance;
  Vector3 step;
  for (int i = 0; i < 3; ++i) step[i] = -gain[i] * z.pull_m;
  Matrix3 keep = identity3();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) keep(i, j) -= gain[i] * z.slope[j];
  PoseGaussian out;
  out.mean = box_plus(prior.mean, step);
  out.covariance = proper_covariance(plus_outer(sandwich(keep, prior.covariance), variance, gain));
  return out;
}

/// With one innovation per beam, in information form, iterated (SPEC 8.2): Gauss-Newton scan matching to the
/// distance field, with the motion as prior. One iteration about `at`. Not ok: nothing can be said, and
/// nothing changes.
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
