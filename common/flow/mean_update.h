// What a scan does to the filter as a whole, measurement by measurement: the Kalman update of its Gaussian,
// and the flow's steps linearised at the mean. It asks for the scan at one pose after another; who adds up
// the beams there is the backend's affair.
#pragma once

#include "common/flow/cloud_move.h"
#include "common/flow/flow_state.h"
#include "common/flow/kalman_update.h"

namespace parloc {

PARLOC_HD Vector3 mean_of(const Moments& m) {
  Vector3 x;
  x[0] = m.x, x[1] = m.y, x[2] = m.theta;
  return x;
}
PARLOC_HD Matrix3 covariance_of(const Moments& m) {
  Matrix3 p;
  p(0, 0) = m.xx, p(1, 1) = m.yy, p(2, 2) = m.tt;
  p(0, 1) = p(1, 0) = m.xy;
  p(0, 2) = p(2, 0) = m.xt;
  p(1, 2) = p(2, 1) = m.yt;
  return p;
}

/// The nearest number of 24 bits, a float32 (Veltkamp's splitting). Not by converting to and fro: GCC 12
/// takes that for nothing where it puts several side by side in a vector.
PARLOC_HD double in_float32(double x) {
  const double scaled = x * 536870913.0;  // 2^29 + 1
  return scaled + (x - scaled);
}
PARLOC_HD Vector3 in_float32(const Vector3& x) {
  Vector3 y;
  for (int i = 0; i < 3; ++i) y[i] = in_float32(x[i]);
  return y;
}

/// Moves the Gaussian by odometry; state.cloud: of the predicted particles, if there are any.
PARLOC_HD void predict_state(FlowState& state, const FlowRules& rules, const MotionNoise& motion) {
  state.prior = predicted(state.posterior, motion);
  state.centre = state.prior.mean;
  if (!is_kalman(rules.method) && rules.method != FlowMethod::pfpf) {
    state.centre = in_float32(mean_of(state.cloud));
    if (rules.prior != FlowPrior::ekf) state.prior.mean = state.centre;
    if (rules.prior == FlowPrior::sample) {
      state.prior.covariance = covariance_of(state.cloud);
      for (int i = 0; i < 3; ++i) state.prior.covariance(i, i) += 1e-9;
      state.prior.covariance = proper_covariance(state.prior.covariance);
    }
  }
  state.posterior = state.prior;
  state.scan = FieldMeasurement{};
  state.nis = state.stiffness = 0.0;
  state.r_scale = 1.0;
  state.skip = FlowSkip::no_scan;
}

/// The psi-based update and the flow at the mean.
class MeanUpdate {
 public:
  using Terms = MeanTerms;

  /// Scans that it asks for.
  PARLOC_HD static int most_sums(const FlowRules& rules) {
    return moves_as_one(rules.method) ? first_flow_sum(rules) + rules.times.steps : 1;
  }
  PARLOC_HD void begin(const FlowState& state, const FlowRules& rules) {
    asked_ = 0;
    flow_from_ = first_flow_sum(rules);
    wanted_ = most_sums(rules);
    map_.clear();
    at_ = state.prior.mean;
  }
  PARLOC_HD bool done() const { return asked_ >= wanted_; }
  PARLOC_HD const Vector3& at() const { return at_; }

  PARLOC_HD void take(const BeamTerms<Terms::kSums>& sum, double beams, const DistanceField& field,
                      const FlowRules& rules, FlowState& state) {
    const FieldMeasurement z = finish_measurement(sum, beams, field);
    if (asked_ == 0) update_gaussian(z, rules, state);
    if (state.skip == FlowSkip::none && moves_as_one(rules.method) && asked_ >= flow_from_)
      flow_on(z, asked_ - flow_from_, rules, state);
    ++asked_;
    if (state.skip != FlowSkip::none) wanted_ = asked_;
    at_ = box_plus(state.centre, map_.b);
  }
  PARLOC_HD void end(const FlowState& state, CloudMove& move) const {
    finish_cloud_move(map_, state.centre, move);
  }

 private:
  /// In reaches of the field: the width of the valley around a wall.
  static constexpr double kLongestStep = 2.0;

  /// A Kalman filter beside the particles has a mean of its own, which the flow does not start from.
  PARLOC_HD static int first_flow_sum(const FlowRules& rules) {
    return rules.prior == FlowPrior::ekf ? 1 : 0;
  }
  PARLOC_HD static void update_gaussian(const FieldMeasurement& z, const FlowRules& rules, FlowState& state) {
    state.scan = z;
    state.skip = has_slope(z) ? FlowSkip::none : FlowSkip::no_slope;
    if (state.skip != FlowSkip::none) return;
    const Matrix3& p = state.prior.covariance;
    const double r = psi_variance(z, rules.noise);
    const GatedNoise gated = gate(p, z, r, rules.gate);
    state.nis = gated.nis;
    state.stiffness = dot(z.slope, multiply(p, z.slope)) / gated.variance;
    state.r_scale = gated.variance / r;
    if (gated.rejected) {
      state.skip = FlowSkip::gated;
      return;
    }
    // A flow's steps are short, and each looks the field up anew.
    const double variance =
        is_kalman(rules.method)
            ? short_step_variance(p, z, gated.variance, kLongestStep * rules.cap_cells * rules.resolution_m)
            : gated.variance;
    state.posterior = kalman_update(state.prior, z, variance);
  }
  /// map_.b is where the flow has brought the mean: the field is linearised there.
  PARLOC_HD void flow_on(const FieldMeasurement& z, int j, const FlowRules& rules, const FlowState& state) {
    if (!has_slope(z)) return;
    const Vector3 k = multiply(state.prior.covariance, z.slope);
    const double s = dot(z.slope, k), r = state.r_scale * psi_variance(z, rules.noise);
    const double y = dot(z.slope, map_.b) - z.pull_m;
    const Stretch t = rules.times.stretch(j, state.stiffness);
    const FlowStep f = rules.method == FlowMethod::gromov ? gromov_step(t, s, r, y)
                       : rules.euler                      ? euler_step(t, s, r, y)
                                                          : closed_form_step(t, s, r, y);
    map_.append(f, k, z.slope);
  }

  int asked_ = 0, wanted_ = 0, flow_from_ = 0;
  Vector3 at_;
  CloudMap map_;
};

/// The Kalman filter with an innovation per beam.
class BeamsUpdate {
 public:
  using Terms = InformationTerms;

  PARLOC_HD void begin(const FlowState& state, const FlowRules& rules) {
    left_ = rules.iterations;
    at_ = state.prior.mean;
  }
  PARLOC_HD bool done() const { return left_ <= 0; }
  PARLOC_HD const Vector3& at() const { return at_; }
  PARLOC_HD void take(const BeamTerms<Terms::kSums>& sum, double beams, const DistanceField& field,
                      const FlowRules&, FlowState& state) {
    const ScanInformation scan = finish_information(sum, field);
    --left_;
    if (state.skip == FlowSkip::no_scan) {  // the first time
      state.scan.beams = beams;
      const bool says_something = scan.matrix(0, 0) + scan.matrix(1, 1) + scan.matrix(2, 2) > 0.0;
      state.skip = says_something ? FlowSkip::none : FlowSkip::no_slope;
    }
    const InformationStep next = information_step(state.prior, at_, scan);
    if (!next.ok) state.skip = FlowSkip::no_update;
    if (state.skip != FlowSkip::none) {
      state.posterior = state.prior;
      left_ = 0;
      return;
    }
    at_ = box_plus(at_, next.step);
    state.posterior = {at_, next.covariance};
    if (has_converged(next.step)) left_ = 0;
  }
  PARLOC_HD void end(const FlowState& state, CloudMove& move) const {
    CloudMap still;
    still.clear();
    finish_cloud_move(still, state.centre, move);
  }

 private:
  int left_ = 0;
  Vector3 at_;
};

/// What the particles become, if there are any: the Gaussian goes where they went (but for a Kalman filter
/// beside them), and takes their covariance where it is theirs.
PARLOC_HD void finish_state(FlowState& state, const FlowRules& rules) {
  if (is_kalman(rules.method)) return;
  const bool own_mean = rules.prior == FlowPrior::ekf && rules.method != FlowMethod::pfpf;
  if (!own_mean) state.posterior.mean = mean_of(state.cloud);
  if (rules.method == FlowMethod::pfpf || rules.prior == FlowPrior::sample)
    state.posterior.covariance = proper_covariance(covariance_of(state.cloud));
}

}  // namespace parloc
