#include "common/filter/kld.h"

#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

/// Draws no candidate in vain: those that the bins so far ask for are all needed, whatever they add.
std::size_t enough_particles(const AdaptArgs& a, Workers& workers) {
  std::size_t drawn = 0, needed = a.rule.fewest;
  while (drawn < needed) {
    const std::size_t first = drawn;
    parallel_for(needed - first, workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
      for (std::size_t j = first + begin; j < first + end; ++j)
        bin_find_or_make(a.bins, candidate_bin(a, static_cast<std::uint32_t>(j)));
    });
    drawn = needed;
    needed = kld_needed(a.rule, *a.bins.used_count);
  }
  bin_clear_used(a.bins);
  return drawn;
}

}  // namespace

void FilterStages::adapt(const AdaptArgs& args, Queue& workers) {
  const AdaptArgs a = with_input(args);
  const StrictFloat strict;
  const std::size_t count = a.state->resample != 0 ? enough_particles(a, workers) : a.from.count();
  *a.to.live = a.state->next_count = static_cast<std::uint32_t>(count);
}

}  // namespace parloc::cpu
