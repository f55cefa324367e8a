#include "common/filter/kld.h"

#include "common/math/atomics.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// Larger for an earlier candidate, and above 0: a bin keeps the largest of its candidates.
PARLOC_HD std::uint64_t earliness(std::uint64_t j) {
  return 0xffffffffu - j;
}

/// `a` as it is in this step.
PARLOC_HD AdaptArgs with_input(AdaptArgs a, const StepInput& input) {
  a.key = input.key;
  if (input.all_particles != 0) a.rule = rule_for_all(a.rule);
  return a;
}

/// All candidates that there can be, each into its bin.
struct EnterCandidates {
  AdaptArgs args;
  const StepInput* input;
  std::uint64_t* best;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *best = 0;
    if (args.state->resample == 0) return;
    const AdaptArgs a = with_input(args, *input);
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
  PARLOC_HD void operator()(const Thread& me) const {
    const bool drawn = a.state->resample != 0;
    for (std::size_t j = me.first(); j < a.rule.most; j += me.stride())
      a.first[j] = drawn && a.bins.weight[a.bins.slot_of[j]] == earliness(j) ? 1 : 0;
  }
};

/// The earliest candidate by which there are as many as its bins need.
struct FindEnough {
  AdaptArgs args;
  const StepInput* input;
  std::uint64_t* best;
  PARLOC_HD void operator()(const Thread& me) const {
    if (args.state->resample == 0) return;
    const AdaptArgs a = with_input(args, *input);
    for (std::size_t j = me.first(); j < a.rule.most; j += me.stride())
      if (j + 1 >= kld_needed(a.rule, a.first[j])) atomic_raise(best, earliness(j));
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

void adapt(const AdaptArgs& a, const StepInput* input, Scratch& scratch, Stream stream) {
  const unsigned blocks = blocks_for(a.rule.most);
  std::uint64_t* best = scratch.best.data();
  launch(EnterCandidates{a, input, best}, blocks, stream);
  launch(MarkFirst{a}, blocks, stream);
  inclusive_scan(a.first, a.first, a.rule.most, scratch, stream);
  launch(FindEnough{a, input, best}, blocks, stream);
  launch(SetCount{a, best}, 1, stream);
  clear_used_bins(a.bins, a.rule.most, stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
