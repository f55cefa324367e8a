// The fixed-shape sum of common/math/block_sum.h as one kernel: blocks of threads for 1024 elements each, and
// the last of them to be done adds up what they made, level above level.
#pragma once

#include "common/filter/stages.h"
#include "common/math/block_sum.h"
#include "cuda/queue.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// What the tree makes of so many values: halving after halving, in registers.
template <unsigned kCount>
PARLOC_HD double halved(double (&v)[kCount]) {
  for (unsigned half = kCount / 2; half > 0; half /= 2)
    for (unsigned i = 0; i < half; ++i) v[i] += v[i + half];
  return v[0];
}

/// Values of K sums, which the threads of a block add up together: a thread of one sum does three halvings in
/// one go, so that 256 lanes take three phases and their barriers, not eight.
template <int K>
struct SumRoom {
  static_assert(kThreads == kSumLanes);
  static constexpr unsigned kWays = 8, kLast = 4;  // 256 lanes: 8 x 8 x 4
  static constexpr unsigned kBeside = 4;           // threads of several sums so read from other banks
  double value[K][kSumLanes + kBeside];

  PARLOC_HD void set(unsigned t, const SumVector<K>& x) {
    for (int k = 0; k < K; ++k) value[k][t] = x.v[k];
  }
  /// Of kWidth values of each sum the tree leaves an eighth.
  template <unsigned kWidth>
  PARLOC_HD void fold(unsigned t) {
    constexpr unsigned kLeft = kWidth / kWays;
    for (unsigned n = t; n < K * kLeft; n += kThreads) {
      double* const sum = &value[n / kLeft][n % kLeft];
      double v[kWays];
      for (unsigned i = 0; i < kWays; ++i) v[i] = sum[i * kLeft];
      sum[0] = halved(v);
    }
  }
  /// The last so many values of each sum become one.
  template <unsigned kWidth>
  PARLOC_HD void store(unsigned t, double* to) const {
    if (t >= K) return;
    double v[kWidth];
    for (unsigned i = 0; i < kWidth; ++i) v[i] = value[t][i];
    to[t] = halved(v);
  }
};

/// How the particles of a sum are spread. Of many, a block adds up 1024, four to a thread. Of few, four
/// blocks share these: a block has every fourth lane, with a thread for each particle, and the tree stays
/// within it but for its last two halvings.
struct SumShape {
  static constexpr std::size_t kFewBlocks = 32;  // fewer than four times as many fill no device
  static constexpr unsigned kMostParts = 4, kLanes = kSumLanes / kMostParts;
  std::uint32_t blocks;
  unsigned parts;  // blocks of threads for each of them: 1 or kMostParts

  static SumShape of(std::size_t blocks) {
    return {static_cast<std::uint32_t>(blocks), blocks <= kFewBlocks ? kMostParts : 1};
  }
};

/// The levels above the first, by one block: sums of 1024 sums. What the first level has made lies at `sums`,
/// [blocks][parts][K], each next level behind it.
template <int K>
struct UpperSums {
  static constexpr std::uint32_t kFew = SumRoom<K>::kLast, kSome = kFew * SumRoom<K>::kWays;
  double* sums;
  SumShape shape;
  int phases;  // worked out once, on the host

  UpperSums(double* sums_there, const SumShape& shape_there)
      : sums(sums_there), shape(shape_there), phases(shape.parts > 1 ? 1 : 0) {
    for (std::uint32_t here = shape.blocks; here > 1; here = blocks_of(here))
      phases += static_cast<int>(blocks_of(here)) * phases_each(here);
  }
  PARLOC_HD static std::uint32_t blocks_of(std::uint32_t count) {
    return (count + (kSumBlock - 1)) / static_cast<std::uint32_t>(kSumBlock);
  }
  /// Of a block among so many sums. Of few values the first halvings would only add zeros, which changes no
  /// bit.
  PARLOC_HD static int phases_each(std::uint32_t count) {
    return count <= kFew ? 1 : (count <= kSome ? 2 : 4);
  }

  PARLOC_HD void operator()(unsigned t, int phase, SumRoom<K>& room) const {
    double* from = sums;
    std::uint32_t count = shape.blocks;
    if (shape.parts > 1) {
      if (phase == 0) return join_parts(t);
      from += std::size_t{SumShape::kMostParts} * count * K;
      phase -= 1;
    }
    int each = phases_each(count);
    for (int level; phase >= (level = static_cast<int>(blocks_of(count)) * each); each = phases_each(count)) {
      phase -= level;
      from += std::size_t{count} * K;
      count = blocks_of(count);
    }
    const std::uint32_t block = static_cast<std::uint32_t>(phase / each);
    const std::uint32_t first = block * static_cast<std::uint32_t>(kSumBlock);
    double* const to = from + std::size_t{count + block} * K;
    from += std::size_t{first} * K;
    if (each == 1) return add_few(t, from, count, to);
    if (each == 2) return phase == 0 ? fold_some(t, from, count, room) : room.template store<kFew>(t, to);
    add_many(t, phase % each, from, count - first, room, to);
  }
  /// Where the one sum of all is, in the end.
  PARLOC_HD const double* result() const {
    const double* at = sums + (shape.parts > 1 ? std::size_t{SumShape::kMostParts} * shape.blocks * K : 0);
    for (std::uint32_t here = shape.blocks; here > 1; here = blocks_of(here)) at += std::size_t{here} * K;
    return at;
  }

 private:
  PARLOC_HD void join_parts(unsigned t) const {
    constexpr unsigned kParts = SumShape::kMostParts;
    double* const to = sums + std::size_t{kParts} * shape.blocks * K;
    for (unsigned n = t; n < shape.blocks * K; n += kThreads) {
      double v[kParts];
      for (unsigned part = 0; part < kParts; ++part) v[part] = sums[(n / K * kParts + part) * K + n % K];
      to[n] = halved(v);
    }
  }
  PARLOC_HD static void add_few(unsigned t, const double* from, std::uint32_t count, double* to) {
    if (t >= K) return;
    double v[kFew];
    for (std::uint32_t i = 0; i < kFew; ++i) v[i] = i < count ? from[i * K + t] : 0.0;
    to[t] = halved(v);
  }
  PARLOC_HD static void fold_some(unsigned t, const double* from, std::uint32_t count, SumRoom<K>& room) {
    if (t >= K * kFew) return;
    const unsigned k = t % K, left = t / K;
    double v[SumRoom<K>::kWays];
    for (std::uint32_t i = 0; i < SumRoom<K>::kWays; ++i)
      v[i] = left + i * kFew < count ? from[(left + i * kFew) * K + k] : 0.0;
    room.value[k][left] = halved(v);
  }
  PARLOC_HD static void add_many(unsigned t, int phase, const double* from, std::uint32_t count,
                                 SumRoom<K>& room, double* to) {
    if (phase == 1) return room.template fold<kSumLanes>(t);
    if (phase == 2) return room.template fold<kSome>(t);
    if (phase == 3) return room.template store<kFew>(t, to);
    for (unsigned n = t; n < K * kSumLanes; n += kThreads) {  // neighbours read neighbours
      double sum = 0.0;
      for (unsigned row = 0; row < kSumBlock / kSumLanes; ++row)
        if (row * kSumLanes + n / K < count) sum += from[row * kSumLanes * K + n];
      room.value[n % K][n / K] = sum;
    }
  }
};

/// Sums term(i) over the particles; all threads of a block call finish(thread, sums) behind it. A term that
/// has `beside(thread)` has every thread call it once, for work that only happens to be done in the same go.
/// Blocks without particles add exactly 0: the bits are those of a sum whose shape is made for just these
/// particles.
template <int K, class Term, class Finish>
struct SumBlocks {
  struct Shared {
    SumRoom<K> room;
    bool last;
  };
  static constexpr int kJoin = 4;  // terms, two foldings, store
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
    }
    if (phase < kJoin)
      return upper.shape.parts > 1 ? add_part(me, phase, s.room) : add_whole(me, phase, s.room);
    if (phase + 1 < phases()) return upper(me.thread, phase - kJoin, s.room);
    finish(me.thread, upper.result());
  }

 private:
  PARLOC_HD void add_whole(const Thread& me, int phase, SumRoom<K>& room) const {
    if (phase == 1) return room.template fold<kSumLanes>(me.thread);
    if (phase == 2) return room.template fold<kSumLanes / SumRoom<K>::kWays>(me.thread);
    if (phase == 3)
      return room.template store<SumRoom<K>::kLast>(me.thread, upper.sums + std::size_t{me.block} * K);
    SumVector<K> sum{};
    for (std::size_t row = 0; row < kSumBlock / kSumLanes; ++row) {
      const std::size_t i = me.block * kSumBlock + row * kSumLanes + me.thread;
      if (i >= *live) break;
      const SumVector<K> x = term(i);
      for (int k = 0; k < K; ++k) sum.v[k] += x.v[k];
    }
    room.set(me.thread, sum);
  }
  PARLOC_HD void add_part(const Thread& me, int phase, SumRoom<K>& room) const {
    constexpr unsigned kLanes = SumShape::kLanes, kParts = SumShape::kMostParts;
    if (phase == 1) return add_rows(me.thread, room);
    if (phase == 2) return room.template fold<kLanes>(me.thread);
    if (phase == 3)
      return room.template store<kLanes / SumRoom<K>::kWays>(me.thread,
                                                             upper.sums + std::size_t{me.block} * K);
    const std::size_t lane = me.thread % kLanes * kParts + me.block % kParts;
    const std::size_t i = me.block / kParts * kSumBlock + me.thread / kLanes * kSumLanes + lane;
    room.set(me.thread, i < *live ? term(i) : SumVector<K>{});
  }
  /// What a thread of many particles does with its four.
  PARLOC_HD static void add_rows(unsigned t, SumRoom<K>& room) {
    constexpr unsigned kLanes = SumShape::kLanes;
    for (unsigned n = t; n < K * kLanes; n += kThreads) {
      double* const value = &room.value[n / kLanes][n % kLanes];
      double sum = 0.0;
      for (unsigned row = 0; row < kSumBlock / kSumLanes; ++row) sum += value[row * kLanes];
      value[0] = sum;
    }
  }
};

template <int K, class Term, class Finish>
void block_sum(const Particles& particles, const Term& term, const Finish& finish, Queue& queue) {
  const SumShape shape = SumShape::of(sum_blocks(particles.capacity));
  launch_step(
      SumBlocks<K, Term, Finish>{
          term, finish, particles.live, {queue.scratch.sums.data(), shape}, queue.scratch.arrived.data()},
      shape.blocks * shape.parts, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
