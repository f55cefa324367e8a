// Which particle survives in which slot: integers only, so that equal weights give equal ancestors on every
// backend (SPEC 5.3, 5.4).
#pragma once

#include "common/filter/free_space.h"
#include "common/filter/stages.h"
#include "common/math/fixed_point.h"
#include "common/math/philox.h"

namespace parloc {

/// The smallest i with cumulative[i] > threshold, by bisection. cumulative[count - 1] > threshold must hold.
PARLOC_HD std::uint32_t first_above(const std::uint64_t* cumulative, std::size_t count,
                                    std::uint64_t threshold) {
  std::size_t low = 0, high = count - 1;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (cumulative[middle] > threshold)
      high = middle;
    else
      low = middle + 1;
  }
  return static_cast<std::uint32_t>(low);
}

/// The same of weights whose sums may be in two levels: first the block, then the place in it.
PARLOC_HD std::uint32_t first_above(const Weights& w, std::size_t count, std::uint64_t threshold) {
  if (w.before == nullptr) return first_above(w.cumulative, count, threshold);
  std::size_t block = 0, end = sum_blocks(count);  // the last block that starts at or below the threshold
  while (end - block > 1) {
    const std::size_t middle = (block + end) / 2;
    if (w.before[middle] > threshold)
      end = middle;
    else
      block = middle;
  }
  const std::size_t first = block * kSumBlock, rest = count - first;
  return static_cast<std::uint32_t>(first) +
         first_above(w.cumulative + first, rest < kSumBlock ? rest : kSumBlock, threshold - w.before[block]);
}

/// The same by the paper's linear search (Paz et al. 2012, slides): the reference of the bisection.
PARLOC_HD std::uint32_t first_above_linear(const Weights& w, std::size_t count, std::uint64_t threshold) {
  std::size_t i = 0;
  while (i + 1 < count && w.sum_to(i) <= threshold) ++i;
  return static_cast<std::uint32_t>(i);
}

/// floor((j 2^64 + r) / n) for j < n: the j-th of n equal strata of [0, 2^64), at offset r. Long division.
PARLOC_HD std::uint64_t stratum(std::uint64_t j, std::uint64_t r, std::uint64_t n) {
  const std::uint64_t high = (j << 32) | (r >> 32);
  const std::uint64_t q_high = high / n;
  const std::uint64_t low = ((high % n) << 32) | (r & 0xffffffffu);
  return (q_high << 32) | (low / n);
}

PARLOC_EVERY_CASE
/// The threshold in [0, total) of output slot j for the single-pass schemes.
PARLOC_HD std::uint64_t draw_threshold(ResampleScheme scheme, std::uint64_t j, std::uint64_t n,
                                       std::uint64_t total, const RandomKey& key) {
  const std::uint32_t slot = static_cast<std::uint32_t>(j);
  std::uint64_t v = 0;
  switch (scheme) {
    case ResampleScheme::systematic:
      v = stratum(j, word64(philox(0, key.step, Stream::systematic, 0, key.seed)), n);
      break;
    case ResampleScheme::stratified:
      v = stratum(j, word64(philox(slot, key.step, Stream::stratified, 0, key.seed)), n);
      break;
    case ResampleScheme::multinomial:
    case ResampleScheme::multinomial_linear:
      v = word64(philox(slot, key.step, Stream::multinomial, 0, key.seed));
      break;
    case ResampleScheme::residual:
      break;  // It does not ask.
  }
  return multiply_high(v, total);
}
PARLOC_EVERY_CASE_END

/// Residual scheme: whole copies of a particle, floor(N q / T), and what is left over (scaled down by `shift`
/// bits where the sum of the left-overs would not fit 64 bits).
PARLOC_HD std::uint64_t whole_copies(std::uint64_t weight, std::uint64_t n, std::uint64_t total) {
  return n * weight / total;
}
PARLOC_HD int remainder_shift(std::uint64_t n, std::uint64_t total) {
  int bits = 0;
  while ((n >> bits) != 0) ++bits;
  int total_bits = 0;
  while ((total >> total_bits) != 0) ++total_bits;
  const int excess = bits + total_bits - 63;
  return excess > 0 ? excess : 0;
}
PARLOC_HD std::uint64_t left_over(std::uint64_t weight, std::uint64_t n, std::uint64_t total, int shift) {
  return (n * weight % total) >> shift;
}

/// The ancestor of output slot j. Not resampling: itself.
PARLOC_HD std::uint32_t ancestor_of(const ResampleArgs& a, std::uint64_t j) {
  if (a.state->resample == 0) return static_cast<std::uint32_t>(j);
  const std::size_t n = a.from.count();
  if (a.scheme == ResampleScheme::residual) {
    const std::uint64_t copies = a.offspring_sum[n - 1];
    if (j < copies) return first_above(a.offspring_sum, n, j);
    const std::uint64_t left = a.remainder_sum[n - 1];
    if (left == 0)
      return static_cast<std::uint32_t>(j % n);  // all scaled away: cannot be worse than unchanged
    const std::uint32_t draw = static_cast<std::uint32_t>(j - copies);
    const std::uint64_t v = word64(philox(draw, a.key.step, Stream::residual, 0, a.key.seed));
    return first_above(a.remainder_sum, n, multiply_high(v, left));
  }
  const std::uint64_t threshold = draw_threshold(a.scheme, j, a.to.count(), a.state->total, a.key);
  return a.scheme == ResampleScheme::multinomial_linear ? first_above_linear(a.weights, n, threshold)
                                                        : first_above(a.weights, n, threshold);
}

/// Fills one slot of the other buffer.
PARLOC_HD void gather_one(const ResampleArgs& a, std::size_t j, std::uint32_t from) {
  a.to.x[j] = a.from.x[from];
  a.to.y[j] = a.from.y[from];
  a.to.theta[j] = a.from.theta[from];
  a.to.log_weight[j] = a.state->resample != 0 ? 0.0f : a.from.log_weight[j];
}

constexpr std::uint32_t kNoAncestor = 0xffffffffu;

/// Replaces what slot j holds by a pose from free space, if its turn has come.
PARLOC_HD void inject_one(const ResampleArgs& a, std::uint32_t j) {
  if (!is_injected(a.free, a.state->inject, j, a.key)) return;
  const GridPose pose = injected_pose(a.free, j, a.key);
  a.to.x[j] = pose.x;
  a.to.y[j] = pose.y;
  a.to.theta[j] = pose.theta;
  a.ancestor[j] = kNoAncestor;
}

}  // namespace parloc
