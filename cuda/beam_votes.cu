#include "common/filter/beam_votes.h"

#include "common/filter/trace_beam.h"
#include "common/math/atomics.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// A thread asks a few voters about one hit, and adds up what they say in one go.
struct Vote {
  WeightArgs args;
  std::size_t voters_per_thread;

  PARLOC_HD void operator()(const Thread& me) const {
    const WeightArgs a = with_input(args);
    const std::size_t hits = a.rays.beams.hits;
    const std::size_t groups = (voters(a) + voters_per_thread - 1) / voters_per_thread;
    for (std::size_t work = me.first(); work < groups * hits; work += me.stride()) {
      const std::size_t m = work % hits, first = work / hits * voters_per_thread;
      const std::size_t last = min_size(first + voters_per_thread, voters(a));
      if (a.model == SensorModel::class_conditional)
        ask_for_class(a, m, first, last);
      else
        ask_for_agreement(a, m, first, last);
    }
  }
  PARLOC_HD static std::size_t min_size(std::size_t x, std::size_t y) { return x < y ? x : y; }

  PARLOC_HD static void ask_for_class(const WeightArgs& a, std::size_t m, std::size_t first,
                                      std::size_t last) {
    const Beams& b = a.rays.beams;
    const ClassConditionalBeam model{a.models.censored};
    std::uint64_t map = 0, unmapped = 0;
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = voter_slot(a, k);
      const float expected_m = a.rays.expected_m != nullptr ? a.rays.expected_m[i * b.count + m]
                                                            : trace_beam(a.rays, ray_origin(a.rays, i), m);
      const ClassVotes votes = class_votes(model, weight_before(a.rays.particles, i), b.range_m[m],
                                           b.short_density[m], expected_m);
      map += static_cast<std::uint64_t>(votes.map);
      unmapped += static_cast<std::uint64_t>(votes.unmapped);
    }
    atomic_add(a.votes.map + m, map);
    atomic_add(a.votes.unmapped + m, unmapped);
  }

  PARLOC_HD static void ask_for_agreement(const WeightArgs& a, std::size_t m, std::size_t first,
                                          std::size_t last) {
    const Particles& p = a.rays.particles;
    std::uint64_t votes = 0;
    for (std::size_t i = first; i < last; ++i) {
      const SinCos h = portable_sincos(p.theta[i]);
      const float u0 = p.x[i] * a.rays.map.inv_resolution, v0 = p.y[i] * a.rays.map.inv_resolution;
      votes += agrees(a, u0, v0, h, m) ? 1 : 0;
    }
    atomic_add(a.votes.map + m, votes);
  }
};

struct Decide {  // one block: shares from votes; leaves the votes zero
  struct Shared {
    std::uint32_t skipped;
  };
  static constexpr int kPhases = 3;
  WeightArgs args;

  PARLOC_HD void operator()(const Thread& me, int phase, Shared& shared) const {
    if (phase == 0 && me.thread == 0) shared.skipped = 0;
    if (phase == 0) return;
    const WeightArgs a = with_input(args);
    if (phase == 2 && !skips_nothing(a, shared.skipped)) return;
    for (std::size_t m = me.thread; m < a.rays.beams.count; m += kThreads) {
      const float share = phase == 1 ? share_of_votes(a, m) : 1.0f;
      a.votes.share[m] = share;
      if (share == 0.0f) atomic_add(&shared.skipped, 1u);
      a.votes.map[m] = a.votes.unmapped[m] = 0;
    }
  }
};

}  // namespace

void FilterStages::beam_votes(const WeightArgs& args, Queue& queue) {
  constexpr std::size_t kUsualBeams = 128;  // more or fewer only change how often a thread comes round
  const std::size_t per_thread = args.model == SensorModel::class_conditional ? 1 : 64;
  const std::size_t most = voters_of(args.model, args.rays.particles.capacity);
  const std::size_t groups = (most + per_thread - 1) / per_thread;
  launch(Vote{args, per_thread}, blocks_for(groups * kUsualBeams), queue);
  launch(Decide{args}, 1, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
