// The flow of one particle, linearised at that particle (LEDH) or along a noise-free path of its own (PF-PF):
// SPEC 7.7, 7.8; Ding and Coates 2012, Li and Coates 2017. Like MeanUpdate it asks for the scan at one pose
// after another.
#pragma once

#include "common/flow/exact_flow.h"
#include "common/flow/flow_state.h"
#include "common/math/philox.h"

namespace parloc {

/// A particle's own prior: where odometry says that it goes, how surely, and where it was drawn.
struct Proposal {
  Vector3 mean;
  Matrix3 covariance;
  Vector3 drawn;  ///< From the mean.
};

/// Normals of stream `motion`: block 0 for the motion, block 1 for the noise besides. Drawn from exactly the
/// Gaussian whose density the weight takes.
PARLOC_HD Proposal propose(const Vector3& pose, const MotionNoise& u, const FlowRules& rules,
                           std::uint32_t slot, const RandomKey& key) {
  const double xy = rules.pfpf_sigma_xy, theta = rules.pfpf_sigma_theta;
  const Normals motion = normals(philox(slot, key.step, Stream::motion, 0, key.seed));
  const Normals besides = normals(philox(slot, key.step, Stream::motion, 1, key.seed));
  Proposal p;
  p.mean = moved(pose, u);
  const Matrix3 v = motion_jacobian(pose, u);
  p.covariance = sandwich(v, diagonal3(u.variance[0], u.variance[1], u.variance[2]));
  Vector3 n;
  for (int i = 0; i < 3; ++i) n[i] = __builtin_sqrt(u.variance[i]) * static_cast<double>(motion.n[i]);
  p.drawn = multiply(v, n);
  for (int i = 0; i < 3; ++i) {
    const double sigma = i < 2 ? xy : theta;
    p.covariance(i, i) += sigma * sigma;
    p.drawn[i] += sigma * static_cast<double>(besides.n[i]);
  }
  p.covariance = proper_covariance(p.covariance);
  return p;
}

PARLOC_HD Vector3 pose_of(const Particles& p, std::size_t i) {
  Vector3 x;
  x[0] = p.x[i], x[1] = p.y[i], x[2] = p.theta[i];
  return x;
}
PARLOC_HD void put_pose(const Vector3& pose, const Particles& p, std::size_t i) {
  p.x[i] = static_cast<float>(pose[0]);
  p.y[i] = static_cast<float>(pose[1]);
  p.theta[i] = wrap(static_cast<float>(pose[2]));
}

class ParticleFlow {
 public:
  /// Scans that a particle asks for.
  PARLOC_HD static int most_sums(const FlowRules& rules) {
    return rules.times.steps + (rules.method == FlowMethod::pfpf ? 1 : 0);
  }
  /// About `origin`, with the prior of all particles.
  PARLOC_HD void begin_local(const Vector3& origin, const Matrix3& covariance, const Vector3& pose,
                             const FlowRules& rules) {
    origin_ = origin;
    covariance_ = covariance;
    e_ = path_ = box_minus(pose, origin);
    own_path_ = false;
    wanted_ = rules.times.steps;
    asked_ = 0;
    stiffness_ = log_weight_ = 0.0;
  }
  PARLOC_HD void begin_weighted(const Proposal& p, const FlowRules& rules) {
    origin_ = p.mean;
    covariance_ = p.covariance;
    e_ = p.drawn;
    path_ = Vector3{};
    own_path_ = true;
    wanted_ = rules.times.steps + 1;  // and once where the particle ends
    asked_ = 0;
    stiffness_ = 0.0;
    log_weight_ = 0.5 * gaussian_exponent(cholesky(p.covariance), p.drawn);
  }
  PARLOC_HD bool done() const { return asked_ >= wanted_; }
  PARLOC_HD Vector3 at() const { return box_plus(origin_, last() ? e_ : path_); }

  PARLOC_HD void take(const FieldMeasurement& z, const FlowRules& rules, double r_scale) {
    const double r = r_scale * psi_variance(z, rules.noise);
    if (last()) {
      log_weight_ -= 0.5 * gaussian_exponent(cholesky(covariance_), e_);
      log_weight_ -= 0.5 * (z.psi_m * z.psi_m / r + portable_log64(2.0 * kPi * r));
    } else if (has_slope(z)) {
      flow_on(z, r, rules);
    }
    ++asked_;
  }
  PARLOC_HD Vector3 pose() const { return box_plus(origin_, e_); }
  /// log of: its prior's density where it ends over that where it was drawn, times the scan's likelihood,
  /// times the determinants of its steps.
  PARLOC_HD double log_weight() const { return log_weight_; }

 private:
  PARLOC_HD bool last() const { return own_path_ && asked_ + 1 == wanted_; }
  PARLOC_HD void flow_on(const FieldMeasurement& z, double r, const FlowRules& rules) {
    const Vector3 k = multiply(covariance_, z.slope);
    const double s = dot(z.slope, k), y = dot(z.slope, path_) - z.pull_m;
    if (asked_ == 0) stiffness_ = s / r;
    const Stretch t = rules.times.stretch(asked_, stiffness_);
    const FlowStep f = rules.euler ? euler_step(t, s, r, y) : closed_form_step(t, s, r, y);
    e_ = flowed(e_, f, k, z.slope);
    path_ = own_path_ ? flowed(path_, f, k, z.slope) : e_;
    log_weight_ += log_determinant(f, s);
  }

  Vector3 origin_, e_, path_;
  Matrix3 covariance_;
  int asked_ = 0, wanted_ = 0;
  bool own_path_ = false;
  double stiffness_ = 0.0, log_weight_ = 0.0;
};

}  // namespace parloc
