// Inclusive sums of 64-bit integers, 1024 in a block: sums within the blocks, and what comes before each
// block.
#pragma once

#include "common/math/block_sum.h"
#include "cuda/queue.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// One block's sum of what its threads have, thread by thread: after each step a value holds four times as
/// many.
struct ScanRoom {
  static constexpr int kSteps = 4;
  std::uint64_t sum[2][kThreads];  // by turns

  PARLOC_HD void set(unsigned t, std::uint64_t value) { sum[0][t] = value; }
  /// 0 to kSteps - 1, with a barrier between.
  PARLOC_HD void step(unsigned t, int step) {
    const unsigned offset = 1u << 2 * step;
    const std::uint64_t* from = sum[step % 2];
    std::uint64_t here = from[t];
    for (unsigned back = offset; back < 4 * offset; back += offset) here += t >= back ? from[t - back] : 0;
    sum[(step + 1) % 2][t] = here;
  }
  /// Steps that are enough where only the first so many threads have anything.
  PARLOC_HD static int steps_for(std::size_t threads) {
    int steps = 0;
    while (steps < kSteps && (std::size_t{1} << 2 * steps) < threads) ++steps;
    return steps;
  }
  /// What the threads before t have, after so many steps; t is one of those that have anything.
  PARLOC_HD std::uint64_t before(unsigned t, int steps = kSteps) const {
    return t > 0 ? sum[steps % 2][t - 1] : 0;
  }
  PARLOC_HD std::uint64_t total() const { return sum[kSteps % 2][kThreads - 1]; }
};

/// Sums of 1024 values by 256 threads of four neighbours each.
struct BlockScan {
  static constexpr unsigned kEach = kSumBlock / kThreads;
  ScanRoom room;
  std::uint64_t value[kSumBlock];

  PARLOC_HD void add_up(unsigned t) {
    std::uint64_t sum = 0;
    for (unsigned k = 0; k < kEach; ++k) sum += value[t * kEach + k];
    room.set(t, sum);
  }
  /// Running sums in place of the values.
  PARLOC_HD void run_on(unsigned t) {
    std::uint64_t sum = room.before(t);
    for (unsigned k = 0; k < kEach; ++k) value[t * kEach + k] = sum += value[t * kEach + k];
  }
};

/// The totals of blocks become what comes before each block; by one block of threads.
struct ScanTotals {
  std::uint64_t* before;  // [blocks] in: total of the block
  std::uint32_t blocks, each, threads;
  int steps;  // these worked out once, on the host

  ScanTotals(std::uint64_t* totals, std::size_t block_count)
      : before(totals),
        blocks(static_cast<std::uint32_t>(block_count)),
        each((blocks + kThreads - 1) / kThreads),
        threads((blocks + each - 1) / each),
        steps(ScanRoom::steps_for(threads)) {}

  PARLOC_HD int phases() const { return 2 + steps; }
  PARLOC_HD void operator()(unsigned t, int phase, ScanRoom& room) const {
    const std::uint32_t first = t < threads ? t * each : blocks;
    const std::uint32_t end = first + each < blocks ? first + each : blocks;
    if (phase == 0) {
      std::uint64_t sum = 0;
      for (std::uint32_t b = first; b < end; ++b) sum += before[b];
      room.set(t, sum);
    } else if (phase <= steps) {
      room.step(t, phase - 1);
    } else if (t < threads) {
      std::uint64_t sum = room.before(t, steps);
      for (std::uint32_t b = first; b < end; ++b) {
        const std::uint64_t here = before[b];
        before[b] = sum;
        sum += here;
      }
    }
  }
  /// Of all blocks, after all phases; for any thread.
  PARLOC_HD std::uint64_t total(const ScanRoom& room) const { return room.sum[steps % 2][threads - 1]; }
};

/// within[i] = sum of value(j) for j from the first of i's 1024 to i; before[i / 1024]: of all j in front of
/// them.
template <class Value>
struct ScanBlocks {
  struct Shared {
    BlockScan scan;
    bool last;
  };
  static constexpr int kJoin = 3 + ScanRoom::kSteps;  // values, steps between adding up and writing
  Value value;
  std::uint64_t* within;
  ScanTotals totals;
  std::size_t count;
  std::uint32_t* arrived;

  PARLOC_HD int join_phase() const { return kJoin + 1; }
  PARLOC_HD int phases() const { return join_phase() + totals.phases(); }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const unsigned t = me.thread;
    const std::size_t first = std::size_t{me.block} * kSumBlock;
    if (phase == 0) {
      for (std::size_t k = t; k < kSumBlock; k += kThreads)
        s.scan.value[k] = first + k < count ? value(first + k) : 0;
    } else if (phase == 1) {
      s.scan.add_up(t);
    } else if (phase < 2 + ScanRoom::kSteps) {
      s.scan.room.step(t, phase - 2);
    } else if (phase + 1 == kJoin) {
      s.scan.run_on(t);
    } else if (phase == kJoin) {
      for (std::size_t k = t; k < kSumBlock && first + k < count; k += kThreads)
        within[first + k] = s.scan.value[k];
      if (t == 0) totals.before[me.block] = s.scan.room.total();
    } else {
      totals(t, phase - join_phase(), s.scan.room);
    }
  }
};

/// Running sums of value(0) to value(count - 1) in two levels, as ScanBlocks has them. `before`: room for
/// sum_blocks(count).
template <class Value>
void scan_in_blocks(const Value& value, std::size_t count, std::uint64_t* within, std::uint64_t* before,
                    Queue& queue) {
  const std::size_t blocks = sum_blocks(count);
  launch_step(ScanBlocks<Value>{value, within, {before, blocks}, count, queue.scratch.arrived.data()},
              static_cast<unsigned>(blocks), queue);
}

/// sums[i] = sums[0] + ... + sums[i], in place. Allocates where `count` was never so large.
void inclusive_scan(std::uint64_t* sums, std::size_t count, Queue& queue);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
