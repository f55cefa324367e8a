// From log-weights to fixed-point weights and the decision to resample (SPEC 3.2, 5.1, 5.4).
#pragma once

#include "common/filter/stages.h"
#include "common/filter/weights/recovery.h"
#include "common/math/fixed_point.h"

namespace parloc {

constexpr float kNoWeight = -__builtin_inff();

/// NaN counts as "impossible"; so does +inf, which would be a defect of a model.
PARLOC_HD float valid_log_weight(float log_weight) {
  return log_weight < __builtin_inff() ? log_weight : kNoWeight;  // false for NaN too
}

/// Shifts a log-weight to maximum 0 and returns its integer weight. A weight of zero stays zero: its
/// log-weight becomes -inf, so that whoever skips such a particle and whoever computes it agree afterwards.
PARLOC_HD std::uint64_t normalise_one(float& log_weight, const StepState& state, int bits) {
  if (state.degenerate != 0) {
    log_weight = 0.0f;
    return std::uint64_t{1} << bits;
  }
  const float valid = valid_log_weight(log_weight);
  const std::uint64_t q = fixed_weight(valid, state.max_log_weight, bits);
  log_weight = q > 0 ? valid - state.max_log_weight : kNoWeight;
  return q;
}

/// What the whole set makes of its weights: N_eff = total^2 / sum(q^2), the likelihood of the scan, and the
/// decision to resample. From sums that no thread schedule can change; on one thread.
PARLOC_HD void finish_normalising(const NormaliseArgs& a, std::uint64_t total, double squares) {
  StepState& state = *a.state;
  const std::size_t count = a.particles.count();
  const float scan_worth = a.input->scan_worth;
  if (scan_worth > 0.0f) {
    // After resampling, and at the start, log-weights are 0.
    const bool uniform = state.resample != 0 || state.total == 0;
    const std::uint64_t before =
        uniform ? std::uint64_t{count} << weight_bits(a.particles.capacity) : state.total;
    average_likelihood(state.likelihood, scan_log_likelihood(state, total, before, scan_worth), a.recovery);
  }
  state.inject = scan_worth > 0.0f ? injected_share(state.likelihood, a.recovery) : 0.0;
  state.count = state.next_count = static_cast<std::uint32_t>(count);
  state.total = total;
  const double t = static_cast<double>(total);
  state.n_eff = t * t / squares;
  const bool few = t * t < a.threshold * static_cast<double>(count) * squares;
  state.resample = a.always || few || state.inject > 0.0 ? 1u : 0u;
}

}  // namespace parloc
