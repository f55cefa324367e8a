#include "common/filter/weights/normalise.h"

#include "cpu/block_sum.h"
#include "cpu/scan.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

float max_log_weight(const Particles& p, Workers& workers) {
  // A maximum does not depend on the order: blocks of a fixed size, one slot each.
  constexpr std::size_t kGrain = 4096;
  const std::size_t count = p.count();
  const std::size_t blocks = (count + kGrain - 1) / kGrain;
  workers.sums.resize(blocks);
  double* best = workers.sums.data();
  const float* log_weight = p.log_weight;
  parallel_blocks(blocks, count < kSmallLoop ? 1 : workers.threads, 1,
                  [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
                    for (std::size_t b = begin; b < end; ++b) {
                      const std::size_t stop = (b + 1) * kGrain < count ? (b + 1) * kGrain : count;
                      float most = kNoWeight;
                      for (std::size_t i = b * kGrain; i < stop; ++i)
                        most = max_of(valid_log_weight(log_weight[i]), most);
                      best[b] = most;
                    }
                  });
  float most = kNoWeight;
  for (std::size_t b = 0; b < blocks; ++b) most = max_of(static_cast<float>(best[b]), most);
  return most;
}

}  // namespace

void FilterStages::normalise_scan(const NormaliseArgs& a, Queue& workers) {
  StepState& state = *a.state;
  const std::size_t count = a.particles.count();
  const int bits = weight_bits(a.particles.capacity);
  state.max_log_weight = max_log_weight(a.particles, workers);
  state.degenerate = state.max_log_weight == kNoWeight ? 1 : 0;

  float* log_weight = a.particles.log_weight;
  std::uint64_t* weight = a.weights.weight;
  const StepState now = state;
  parallel_for(count, workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t i = begin; i < end; ++i) weight[i] = normalise_one(log_weight[i], now, bits);
  });
  const std::uint64_t total = inclusive_scan(count, workers, a.weights.cumulative,
                                             [=](std::size_t i) PARLOC_SIMD_LOOP { return weight[i]; });
  const SumVector<1> squares = block_sum<1>(count, workers, [=](std::size_t i) PARLOC_SIMD_LOOP {
    const double q = static_cast<double>(weight[i]);
    return SumVector<1>{{q * q}};
  });
  const StrictFloat strict;
  finish_normalising(a, total, squares.v[0]);
}

}  // namespace parloc::cpu
