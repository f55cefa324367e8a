// The fixed-shape sum of common/math/block_sum.h as one kernel: a block of 256 lanes per 1024 elements, and
// the last block to be done adds up what they made, level above level.
#pragma once

#include "common/filter/stages.h"
#include "common/math/block_sum.h"
#include "cuda/queue.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// What the lanes of a block have added up: K sums.
template <int K>
struct SumRoom {
  static_assert(kThreads == kSumLanes);
  static constexpr int kHalvings = 8;
  double lane[K][kSumLanes];

  /// Lane t of the `block`-th 1024 elements of `count`.
  template <class Term>
  PARLOC_HD void load(unsigned t, std::size_t block, std::size_t count, const Term& term) {
    SumVector<K> sum{};
    for (std::size_t row = 0; row < kSumBlock / kSumLanes; ++row) {
      const std::size_t i = block * kSumBlock + row * kSumLanes + t;
      if (i >= count) break;
      const SumVector<K> x = term(i);
      for (int k = 0; k < K; ++k) sum.v[k] += x.v[k];
    }
    for (int k = 0; k < K; ++k) lane[k][t] = sum.v[k];
  }
  /// 0 to kHalvings - 1, with a barrier between.
  PARLOC_HD void halve(unsigned t, int halving) {
    const unsigned offset = (kSumLanes / 2) >> halving;
    if (t < offset)
      for (int k = 0; k < K; ++k) lane[k][t] += lane[k][t + offset];
  }
  PARLOC_HD void store(unsigned t, double* to) const {
    if (t < K) to[t] = lane[t][0];
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

/// The levels above the first: sums of 1024 sums, by one block, one after the other. The first level lies at
/// `sums`, [blocks][K], each next level behind it.
template <int K>
struct UpperSums {
  double* sums;
  std::size_t blocks;
  static constexpr int kPhasesEach = 2 + SumRoom<K>::kHalvings;

  PARLOC_HD int phases() const {
    int all = 0;
    for (std::size_t here = blocks; here > 1; here = sum_blocks(here))
      all += static_cast<int>(sum_blocks(here)) * kPhasesEach;
    return all;
  }
  PARLOC_HD void operator()(unsigned t, int phase, SumRoom<K>& room) const {
    std::size_t block = static_cast<std::size_t>(phase / kPhasesEach);
    const int part = phase % kPhasesEach;
    double* from = sums;
    std::size_t count = blocks;
    while (block >= sum_blocks(count)) {
      block -= sum_blocks(count);
      from += count * K;
      count = sum_blocks(count);
    }
    if (part == 0)
      room.load(t, block, count, ReadSums<K>{from});
    else if (part + 1 < kPhasesEach)
      room.halve(t, part - 1);
    else
      room.store(t, from + (count + block) * K);
  }
  /// Where the one sum of all is, in the end.
  PARLOC_HD const double* result() const {
    const double* at = sums;
    for (std::size_t here = blocks; here > 1; here = sum_blocks(here)) at += here * K;
    return at;
  }
};

/// Sums term(i) over the particles; one thread calls finish(sums) behind it. A term that has `beside(thread)`
/// has every thread call it once, for work that only happens to be done in the same go. Blocks without
/// particles add exactly 0: the bits are those of a sum whose shape is made for just these particles.
template <int K, class Term, class Finish>
struct SumBlocks {
  struct Shared {
    SumRoom<K> room;
    bool last;
  };
  static constexpr int kJoin = 2 + SumRoom<K>::kHalvings;  // lanes, halvings, store
  Term term;
  Finish finish;
  const std::uint32_t* live;  // how many particles
  UpperSums<K> upper;
  std::uint32_t* arrived;

  PARLOC_HD int join_phase() const { return kJoin; }
  PARLOC_HD int phases() const { return kJoin + upper.phases() + 1; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    if (phase == 0) {
      if constexpr (requires { term.beside(me); }) term.beside(me);
      s.room.load(me.thread, me.block, *live, term);
    } else if (phase + 1 < kJoin) {
      s.room.halve(me.thread, phase - 1);
    } else if (phase < kJoin) {
      s.room.store(me.thread, upper.sums + std::size_t{me.block} * K);
    } else if (phase + 1 < phases()) {
      upper(me.thread, phase - kJoin, s.room);
    } else if (me.thread == 0) {
      finish(upper.result());
    }
  }
};

template <int K, class Term, class Finish>
void block_sum(const Particles& particles, const Term& term, const Finish& finish, Queue& queue) {
  const std::size_t blocks = sum_blocks(particles.capacity);
  launch(
      SumBlocks<K, Term, Finish>{
          term, finish, particles.live, {queue.scratch.sums.data(), blocks}, queue.scratch.arrived.data()},
      static_cast<unsigned>(blocks), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
