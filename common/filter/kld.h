// How many particles are enough: KLD-sampling (Fox 2003, SPEC 6.1).
//
// Candidates are drawn one after the other by the weights. The more bins of poses they have occupied, the
// more of them are needed; the first candidate that makes them enough is the last. It need not be done one
// after the other: candidate j is a function of j, the number of bins among the first j has no order, and
// with more bins never fewer particles are needed.
#pragma once

#include "common/filter/bins.h"
#include "common/filter/free_space.h"
#include "common/filter/resampling.h"

namespace parloc {

/// The bound and the bins, bound once on the host (common/filter/bind.h).
struct KldRule {
  double z = 0;       ///< Quantile 1 - delta of the normal distribution, 0 to 5: n(k) then grows with k.
  double pf_err = 0;  ///< [nat]
  std::uint32_t fewest = 0, most = 0;
  float bins_per_m = 0;
  float bins_per_rad = 0;
  std::int32_t heading_bins = 1;
};

struct AdaptArgs {
  Particles from;
  Particles to;  ///< Gets its number of particles, and nothing else.
  Weights weights;
  KldRule rule;
  FreeSpace free;
  BinTable bins;  ///< Empty before and after.
  StepState* state = nullptr;
  const StepInput* input = nullptr;
  RandomKey key{};  ///< From the input.
};

/// Particles that k occupied bins need, whatever the limits (Fox 2003, eq. 7). k >= 2.
PARLOC_HD double kld_bound(std::uint64_t bins, double pf_err, double z) {
  const double k = static_cast<double>(bins) - 1.0;
  const double a = 2.0 / (9.0 * k);
  const double b = 1.0 - a + __builtin_sqrt(a) * z;
  return __builtin_ceil(k / (2.0 * pf_err) * (b * b * b));
}

/// The same within the limits. One bin says that everything is known: the fewest.
PARLOC_HD std::uint32_t kld_needed(const KldRule& rule, std::uint64_t bins) {
  if (bins <= 1) return rule.fewest;
  const double n = kld_bound(bins, rule.pf_err, rule.z);
  if (n >= static_cast<double>(rule.most)) return rule.most;
  const std::uint32_t needed = static_cast<std::uint32_t>(n);
  return needed > rule.fewest ? needed : rule.fewest;
}

/// The rule before the cloud is widened: as many as there can be. What the bins of now ask for would be too
/// few for where the particles are about to be strewn.
PARLOC_HD KldRule rule_for_all(KldRule rule) {
  rule.fewest = rule.most;
  return rule;
}

/// `args` with what the input says of this step.
PARLOC_HD AdaptArgs with_input(AdaptArgs args) {
  args.key = args.input->key;
  if (args.input->all_particles != 0) args.rule = rule_for_all(args.rule);
  return args;
}

PARLOC_HD std::uint64_t kld_bin(const KldRule& rule, const GridPose& p) {
  const auto index = [&](float metres) {
    const float bins = min_of(max_of(metres * rule.bins_per_m, -8e6f), 8e6f);
    return static_cast<std::uint64_t>(static_cast<std::int32_t>(floor_of(bins)) + (1 << 23));
  };
  std::int32_t t = static_cast<std::int32_t>(floor_of((p.theta + 3.14159274f) * rule.bins_per_rad));
  t = t < 0 ? 0 : (t >= rule.heading_bins ? rule.heading_bins - 1 : t);
  return (index(p.x) << 36) | (index(p.y) << 12) | static_cast<std::uint64_t>(t);
}

/// Bin of candidate j: what slot j would hold if offspring were drawn independently.
PARLOC_HD std::uint64_t candidate_bin(const AdaptArgs& a, std::uint32_t j) {
  if (is_injected(a.free, a.state->inject, j, a.key)) return kld_bin(a.rule, injected_pose(a.free, j, a.key));
  const std::uint64_t r = word64(philox(j, a.key.step, Stream::kld, 0, a.key.seed));
  const std::uint32_t i = first_above(a.weights, a.from.count(), multiply_high(r, a.state->total));
  return kld_bin(a.rule, {a.from.x[i], a.from.y[i], a.from.theta[i]});
}

}  // namespace parloc
