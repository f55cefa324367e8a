// The exact particle flow of Daum and Huang for one scalar measurement, as steps in pseudo-time (SPEC 7.4 to
// 7.6, 7.9). Whatever the integrator, a step moves an error e about the prior's mean along one vector:
//
//   e <- e + k (shift - pull H e + noise xi),   k = P H^T,   xi standard normal
//
// which is the affine map I - pull k H with determinant 1 - pull s, s = H k. The pseudo-measurement is
// y = H e_lin - psi(e_lin) = H e + noise of variance r.
#pragma once

#include "common/flow/flow_config.h"
#include "common/flow/pose_algebra.h"

namespace parloc {

struct FlowStep {
  double pull = 0.0, shift = 0.0, noise = 0.0;
};

/// A stretch of pseudo-time, from 0 (prior) to 1 (posterior).
struct Stretch {
  double from, to;
  PARLOC_HD double length() const { return to - from; }
};

/// Mean of the density at pseudo-time lambda, in units of k.
PARLOC_HD double flow_mean(double lambda, double s, double r, double y) {
  return lambda * y / (lambda * s + r);
}

/// The flow's own solution (Toro and Becsi 2022); no division by s.
PARLOC_HD FlowStep closed_form_step(const Stretch& t, double s, double r, double y) {
  const double at_end = t.to * s + r;
  const double ratio = __builtin_sqrt((t.from * s + r) / at_end);
  FlowStep f;
  f.pull = t.length() / (at_end * (1.0 + ratio));
  const double before = flow_mean(t.from, s, r, y);
  f.shift = flow_mean(t.to, s, r, y) - before + f.pull * s * before;
  return f;
}

/// One Euler step, with the field of its end: that of its beginning explodes where s >> r.
PARLOC_HD FlowStep euler_step(const Stretch& t, double s, double r, double y) {
  const double at_end = t.to * s + r;
  FlowStep f;
  f.pull = 0.5 * t.length() / at_end;
  f.shift = t.length() * y * (t.to * s + 2.0 * r) / (2.0 * at_end * at_end);
  return f;
}

/// The stochastic flow of Daum, Huang and Noushin, whose transition over a stretch is exact.
PARLOC_HD FlowStep gromov_step(const Stretch& t, double s, double r, double y) {
  const double at_end = t.to * s + r;
  FlowStep f;
  f.pull = t.length() / at_end;
  f.shift = f.pull * y;
  f.noise = __builtin_sqrt(r * t.length()) / at_end;
  return f;
}

PARLOC_HD Vector3 flowed(const Vector3& e, const FlowStep& f, const Vector3& k, const Vector3& h) {
  return plus(e, f.shift - f.pull * dot(h, e), k);
}

/// log |det| of a step's map, which is above 0 but for rounding.
PARLOC_HD double log_determinant(const FlowStep& f, double s) {
  constexpr double kLeast = 1e-16;
  const double determinant = 1.0 - f.pull * s;
  return portable_log64(determinant > kLeast ? determinant : kLeast);
}

/// Where the steps end, in [0, 1].
struct FlowTimes {
  int steps = 0;
  bool contract = false;  ///< Ends depend on s / r; `end` is not used.
  double end[kMostFlowSteps] = {};

  /// Of step j, by the s / r of the first linearisation.
  PARLOC_HD Stretch stretch(int j, double stiffness) const {
    return {j > 0 ? end_of(j - 1, stiffness) : 0.0, end_of(j, stiffness)};
  }

 private:
  PARLOC_HD double end_of(int j, double stiffness) const {
    if (j + 1 == steps) return 1.0;
    const double part = static_cast<double>(j + 1) / static_cast<double>(steps);
    if (!contract) return end[j];
    if (stiffness < 1e-6) return part;  // no contraction to be shared out
    return (portable_exp64(part * portable_log64(1.0 + stiffness)) - 1.0) / stiffness;
  }
};

inline FlowTimes flow_times(FlowSchedule schedule, int steps, double ratio) {
  FlowTimes t;
  t.steps = steps;
  t.contract = schedule == FlowSchedule::contract;
  const bool even = schedule == FlowSchedule::uniform || ratio == 1.0;
  double length = 1.0, total = 0.0;
  for (int j = 0; j < steps; ++j, length *= even ? 1.0 : ratio) t.end[j] = total += length;
  for (int j = 0; j < steps; ++j) t.end[j] /= total;
  return t;
}

}  // namespace parloc
