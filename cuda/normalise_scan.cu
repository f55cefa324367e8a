#include "common/filter/weights/normalise.h"

#include "cuda/block_sum.h"
#include "cuda/largest_weight.h"
#include "cuda/scan.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// Where weight has not just done it.
struct FindLargest {
  struct Shared {
    std::uint32_t largest;
    bool last;
  };
  static constexpr int kPhases = 4;
  Particles particles;
  LargestOfBlocks result;
  std::uint32_t* arrived;
  PARLOC_HD int join_phase() const { return 3; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    if (phase == 0 && me.thread == 0) s.largest = LargestWeight::kNone;
    if (phase == 1) {
      float largest = kNoWeight;
      for (std::size_t i = me.first(); i < particles.count(); i += me.stride())
        largest = max_of(valid_log_weight(particles.log_weight[i]), largest);
      atomic_raise(&s.largest, ordered(largest));
    }
    if (phase == 2 && me.thread == 0) result.enter(s.largest);
    if (phase == 3 && me.thread == 0) result.take();
  }
};

/// Weights, their running sums and those of their squares, 1024 to a block; the last block decides.
struct NormaliseScan {
  struct Shared {
    BlockScan scan;
    SumRoom<1> squares;
    bool last;
  };
  static constexpr int kSteps = ScanRoom::kSteps;
  static constexpr int kJoin = 4 + kSteps;
  NormaliseArgs a;
  int bits;
  const LargestWeight* largest;
  ScanTotals totals;
  UpperSums<1> upper;
  std::uint32_t* arrived;

  PARLOC_HD int join_phase() const { return kJoin; }
  PARLOC_HD int phases() const { return kJoin + most_of(totals.phases(), upper.phases) + 1; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const unsigned t = me.thread;
    if (phase == 0) return weigh(me, s);
    if (phase == 1) return s.scan.add_up(t);
    if (phase < 2 + kSteps) {  // the squares have nothing to do with it, and share its barriers
      if (phase == 2) s.squares.fold<kSumLanes>(t);
      if (phase == 3) s.squares.fold<kSumLanes / SumRoom<1>::kWays>(t);
      if (phase == 4) s.squares.store<SumRoom<1>::kLast>(t, upper.sums + me.block);
      return s.scan.room.step(t, phase - 2);
    }
    if (phase == 2 + kSteps) return s.scan.run_on(t);
    if (phase < kJoin) return write_sums(me, s);
    if (phase + 1 == phases()) {
      if (t == 0) decide(totals.total(s.scan.room));
      return;
    }
    const int rest = phase - kJoin;
    if (rest < totals.phases()) totals(t, rest, s.scan.room);
    if (rest < upper.phases) upper(t, rest, s.squares);
  }

 private:
  PARLOC_HD static int most_of(int a, int b) { return a > b ? a : b; }
  PARLOC_HD void weigh(const Thread& me, Shared& s) const {
    StepState now{};
    now.max_log_weight = largest->log_weight;
    now.degenerate = now.max_log_weight == kNoWeight ? 1 : 0;
    const std::size_t first = std::size_t{me.block} * kSumBlock, count = a.particles.count();
    double squares = 0.0;
    for (std::size_t k = me.thread; k < kSumBlock; k += kThreads) {
      const std::size_t i = first + k;
      const std::uint64_t q = i < count ? normalise_one(a.particles.log_weight[i], now, bits) : 0;
      if (i < a.particles.capacity) a.weights.weight[i] = q;  // those that do not count are read, too
      s.scan.value[k] = q;
      const double weight = static_cast<double>(q);
      squares += weight * weight;
    }
    s.squares.value[0][me.thread] = squares;
  }
  PARLOC_HD void write_sums(const Thread& me, const Shared& s) const {
    const std::size_t first = std::size_t{me.block} * kSumBlock;
    for (std::size_t k = me.thread; k < kSumBlock && first + k < a.particles.capacity; k += kThreads)
      a.weights.cumulative[first + k] = s.scan.value[k];
    if (me.thread == 0) a.weights.before[me.block] = s.scan.room.total();
  }
  PARLOC_HD void decide(std::uint64_t total) const {
    a.state->max_log_weight = largest->log_weight;
    a.state->degenerate = largest->log_weight == kNoWeight ? 1 : 0;
    finish_normalising(a, total, *upper.result());
  }
};

}  // namespace

void FilterStages::normalise_scan(const NormaliseArgs& a, Queue& queue) {
  const std::size_t count = a.particles.capacity, blocks = sum_blocks(count);
  LargestWeight* const largest = queue.scratch.largest.data();
  std::uint32_t* const arrived = queue.scratch.arrived.data();
  if (!a.just_weighed)
    launch_step(FindLargest{a.particles, {largest}, arrived}, std::min(blocks_for(count), 1024u), queue);
  launch_step(NormaliseScan{a,
                            weight_bits(count),
                            largest,
                            {a.weights.before, blocks},
                            {queue.scratch.sums.data(), {static_cast<std::uint32_t>(blocks), 1}},
                            arrived},
              static_cast<unsigned>(blocks), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
