// From log-weights to fixed-point weights and the decision to resample (SPEC 3.2, 5.1, 5.4).
#pragma once

#include "common/filter/stages.h"
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

/// N_eff = total^2 / sum(q^2) and the decision, from sums that no thread schedule can change.
PARLOC_HD void decide_resampling(StepState& state, double squares, std::size_t count, double threshold,
                                 bool always) {
  const double total = static_cast<double>(state.total);
  state.n_eff = total * total / squares;
  const bool few = total * total < threshold * static_cast<double>(count) * squares;
  state.resample = always || few ? 1u : 0u;
}

}  // namespace parloc
