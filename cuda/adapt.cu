#include "common/filter/kld.h"

#include "common/math/atomics.h"
#include "cuda/scan.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// Larger for an earlier candidate, and above 0: a bin keeps the largest of its candidates.
PARLOC_HD std::uint64_t earliness(std::uint64_t j) {
  return 0xffffffffu - j;
}

/// All candidates that there can be, each into its bin.
struct EnterCandidates {
  AdaptArgs args;
  std::uint64_t* enough;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *enough = 0;
    if (args.state->resample == 0) return;
    const AdaptArgs a = with_input(args);
    for (std::size_t j = me.first(); j < a.rule.most; j += me.stride()) {
      const std::uint32_t slot = bin_find_or_make(a.bins, candidate_bin(a, static_cast<std::uint32_t>(j)));
      const std::uint64_t mine = earliness(j);
      if (atomic_read(&a.bins.weight[slot]) < mine) atomic_raise(&a.bins.weight[slot], mine);
      a.bins.slot_of[j] = slot;
    }
  }
};

/// 1 for a candidate that is the first in its bin.
struct IsFirst {
  AdaptArgs a;
  PARLOC_HD std::uint64_t operator()(std::size_t j) const {
    return a.state->resample != 0 && a.bins.weight[a.bins.slot_of[j]] == earliness(j) ? 1 : 0;
  }
};

/// The earliest candidate by which there are as many as its bins need; the last block says how many that is.
/// The bins are needed no more, and are emptied.
struct FindEnough {
  struct Shared {
    bool last;
  };
  static constexpr int kPhases = 2;
  AdaptArgs args;
  const std::uint64_t *first, *before;  // running count of the first ones, in blocks
  std::uint64_t* enough;
  std::uint32_t* arrived;
  PARLOC_HD int join_phase() const { return 1; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared&) const {
    if (phase == 0)
      search(me);
    else if (me.thread == 0)
      set_count();
  }

 private:
  PARLOC_HD void search(const Thread& me) const {
    const BinTable& t = args.bins;
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) bin_clear(t, t.used[k]);
    if (args.state->resample == 0) return;
    const AdaptArgs a = with_input(args);
    for (std::size_t j = me.first(); j < a.rule.most; j += me.stride())
      if (j + 1 >= kld_needed(a.rule, before[j / kSumBlock] + first[j]) && atomic_read(enough) < earliness(j))
        atomic_raise(enough, earliness(j));
  }
  PARLOC_HD void set_count() const {
    const std::uint64_t count = args.state->resample != 0 ? earliness(*enough) + 1 : args.from.count();
    *args.to.live = args.state->next_count = static_cast<std::uint32_t>(count);
    *args.bins.used_count = 0;
  }
};

}  // namespace

void FilterStages::adapt(const AdaptArgs& a, Queue& queue) {
  const unsigned blocks = blocks_for(a.rule.most);
  queue.scratch.first.reserve(a.rule.most);  // the same in all steps, and so done before one is recorded
  queue.scratch.enough.reserve(1);
  std::uint64_t* const first = queue.scratch.first.data();
  std::uint64_t* const before = queue.scratch.before.data();
  std::uint64_t* const enough = queue.scratch.enough.data();
  launch_step(EnterCandidates{a, enough}, blocks, queue);
  scan_in_blocks(IsFirst{a}, a.rule.most, first, before, queue);
  launch_step(FindEnough{a, first, before, enough, queue.scratch.arrived.data()}, blocks, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
