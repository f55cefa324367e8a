// The fixed-shape sum of common/math/block_sum.h as kernels: one block of 256 lanes per 1024 elements, then
// again.
#pragma once

#include "common/filter/stages.h"
#include "common/math/block_sum.h"
#include "cuda/launch.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

template <int K, class Term>
struct SumBlocks {
  static_assert(kThreads == kSumLanes);
  struct Shared {
    double lane[K][kSumLanes];
  };
  static constexpr int kPhases = 10;  // lanes, eight halvings, store
  Term term;
  std::size_t count;
  const std::uint32_t* live;  // null: all of `count`; else as many as it says
  double* out;                // [blocks][K]
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const unsigned t = me.thread;
    if (phase == 0) {
      const std::size_t there = live != nullptr ? *live : count;
      for (int k = 0; k < K; ++k) s.lane[k][t] = 0.0;
      for (std::size_t row = 0; row < kSumBlock / kSumLanes; ++row) {
        const std::size_t i = std::size_t{me.block} * kSumBlock + row * kSumLanes + t;
        if (i >= there) break;
        const SumVector<K> x = term(i);
        for (int k = 0; k < K; ++k) s.lane[k][t] += x.v[k];
      }
    } else if (phase < 9) {
      const unsigned offset = kSumLanes >> phase;
      if (t < offset)
        for (int k = 0; k < K; ++k) s.lane[k][t] += s.lane[k][t + offset];
    } else if (t < K) {
      out[std::size_t{me.block} * K + t] = s.lane[t][0];
    }
  }
};

template <int K>
struct ReadSums {
  const double* from;
  PARLOC_HD SumVector<K> operator()(std::size_t i) const {
    SumVector<K> x;
    for (int k = 0; k < K; ++k) x.v[k] = from[i * K + k];
    return x;
  }
};

/// Sums term(i) over the particles. Returns where the K sums will be in `scratch`, which holds
/// (blocks + blocks / 1024 + 3) * K doubles. Blocks without particles add exactly 0: the bits are those of a
/// sum whose shape is made for just these particles.
template <int K, class Term>
const double* block_sum(const Particles& particles, const Term& term, double* scratch, Stream stream) {
  std::size_t blocks = sum_blocks(particles.capacity);
  double* level = scratch;
  launch(SumBlocks<K, Term>{term, particles.capacity, particles.live, level}, static_cast<unsigned>(blocks),
         stream);
  while (blocks > 1) {
    double* next = level + blocks * K;
    const std::size_t above = sum_blocks(blocks);
    launch(SumBlocks<K, ReadSums<K>>{{level}, blocks, nullptr, next}, static_cast<unsigned>(above), stream);
    level = next;
    blocks = above;
  }
  return level;
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
