#include "common/filter/kld.h"

#include "common/math/atomics.h"
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
  std::uint64_t* best;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *best = 0;
    if (args.state->resample == 0) return;
    const AdaptArgs a = with_input(args);
    for (std::size_t j = me.first(); j < a.rule.most; j += me.stride()) {
      const std::uint32_t slot = bin_find_or_make(a.bins, candidate_bin(a, static_cast<std::uint32_t>(j)));
      atomic_raise(&a.bins.weight[slot], earliness(j));
      a.bins.slot_of[j] = slot;
    }
  }
};

/// 1 for a candidate that is the first in its bin.
struct MarkFirst {
  AdaptArgs a;
  std::uint64_t* first;
  PARLOC_HD void operator()(const Thread& me) const {
    const bool drawn = a.state->resample != 0;
    for (std::size_t j = me.first(); j < a.rule.most; j += me.stride())
      first[j] = drawn && a.bins.weight[a.bins.slot_of[j]] == earliness(j) ? 1 : 0;
  }
};

/// The earliest candidate by which there are as many as its bins need.
struct FindEnough {
  AdaptArgs args;
  const std::uint64_t* first;  // running count
  std::uint64_t* best;
  PARLOC_HD void operator()(const Thread& me) const {
    if (args.state->resample == 0) return;
    const AdaptArgs a = with_input(args);
    for (std::size_t j = me.first(); j < a.rule.most; j += me.stride())
      if (j + 1 >= kld_needed(a.rule, first[j])) atomic_raise(best, earliness(j));
  }
};

struct SetCount {
  AdaptArgs a;
  const std::uint64_t* best;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() != 0) return;
    const std::uint64_t count = a.state->resample != 0 ? earliness(*best) + 1 : a.from.count();
    *a.to.live = a.state->next_count = static_cast<std::uint32_t>(count);
  }
};

}  // namespace

void FilterStages::adapt(const AdaptArgs& a, Queue& queue) {
  const unsigned blocks = blocks_for(a.rule.most);
  queue.scratch.first.reserve(a.rule.most);  // the same in all steps, and so done before one is recorded
  std::uint64_t *const first = queue.scratch.first.data(), *const best = queue.scratch.best.data();
  launch(EnterCandidates{a, best}, blocks, queue);
  launch(MarkFirst{a, first}, blocks, queue);
  inclusive_scan(first, first, a.rule.most, queue);
  launch(FindEnough{a, first, best}, blocks, queue);
  launch(SetCount{a, best}, 1, queue);
  clear_used_bins(a.bins, a.rule.most, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
