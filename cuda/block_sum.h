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
  /// Of so many values the first halvings would only add zeros, which changes no bit: the first that counts.
  PARLOC_HD static int first_halving(std::uint32_t count) {
    int halving = 0;
    while (halving < kHalvings && ((kSumLanes / 2) >> halving) >= count) ++halving;
    return halving;
  }
  /// 0 to kHalvings - 1, with a barrier between. All threads share the additions of all K sums, or a few
  /// would do K of them one after the other.
  PARLOC_HD void halve(unsigned t, int halving) {
    const unsigned bits = static_cast<unsigned>(kHalvings - 1 - halving), offset = 1u << bits;
    for (unsigned n = t; n < K * offset; n += kThreads) {
      double* const sum = &lane[n >> bits][n & (offset - 1)];
      sum[0] += sum[offset];
    }
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
  std::uint32_t blocks;
  int phases;  // worked out once, on the host

  UpperSums(double* sums_there, std::size_t block_count)
      : sums(sums_there), blocks(static_cast<std::uint32_t>(block_count)), phases(0) {
    for (std::uint32_t here = blocks; here > 1; here = blocks_of(here))
      phases += static_cast<int>(blocks_of(here)) * phases_each(here);
  }
  PARLOC_HD static std::uint32_t blocks_of(std::uint32_t count) {
    return (count + (kSumBlock - 1)) / static_cast<std::uint32_t>(kSumBlock);
  }
  /// Of a block among so many sums: load, halvings, store.
  PARLOC_HD static int phases_each(std::uint32_t count) {
    return 2 + SumRoom<K>::kHalvings - SumRoom<K>::first_halving(count);
  }
  PARLOC_HD void operator()(unsigned t, int phase, SumRoom<K>& room) const {
    double* from = sums;
    std::uint32_t count = blocks;
    int each = phases_each(count);
    for (int level; phase >= (level = static_cast<int>(blocks_of(count)) * each); each = phases_each(count)) {
      phase -= level;
      from += std::size_t{count} * K;
      count = blocks_of(count);
    }
    const std::uint32_t block = static_cast<std::uint32_t>(phase / each);
    const int part = phase % each;
    if (part == 0)
      room.load(t, block, count, ReadSums<K>{from});
    else if (part + 1 < each)
      room.halve(t, SumRoom<K>::first_halving(count) + part - 1);
    else
      room.store(t, from + std::size_t{count + block} * K);
  }
  /// Where the one sum of all is, in the end.
  PARLOC_HD const double* result() const {
    const double* at = sums;
    for (std::uint32_t here = blocks; here > 1; here = blocks_of(here)) at += std::size_t{here} * K;
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
  PARLOC_HD int phases() const { return kJoin + upper.phases + 1; }
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
