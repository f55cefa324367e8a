#include "common/filter/beam_votes.h"

#include "common/math/atomics.h"
#include "cuda/casters.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// class_conditional: a thread asks one voter about one hit, by rays.
template <class Caster>
struct AskForClass {
  WeightArgs args;
  PARLOC_HD void operator()(const Thread& me) const {
    const WeightArgs a = with_input(args);
    const Beams& b = a.rays.beams;
    const ClassConditionalBeam model{a.models.censored};
    for (std::size_t work = me.first(); work < voters(a) * b.hits; work += me.stride()) {
      const std::size_t m = work % b.hits, i = voter_slot(a, work / b.hits);
      const float expected_m = Caster::expected_m(a.rays, ray_origin(a.rays, i), i, m);
      const ClassVotes votes = class_votes(model, weight_before(a.rays.particles, i), b.range_m[m],
                                           b.short_density[m], expected_m);
      atomic_add(a.votes.map + m, static_cast<std::uint64_t>(votes.map));
      atomic_add(a.votes.unmapped + m, static_cast<std::uint64_t>(votes.unmapped));
    }
  }
};

/// likelihood_field_prob: a thread asks some of all particles about one hit, and adds up what they say in one
/// go.
struct AskForAgreement {
  static constexpr std::size_t kEach = 64;
  WeightArgs args;

  PARLOC_HD void operator()(const Thread& me) const {
    const WeightArgs a = with_input(args);
    const std::size_t hits = a.rays.beams.hits, groups = (voters(a) + kEach - 1) / kEach;
    for (std::size_t work = me.first(); work < groups * hits; work += me.stride()) {
      const std::size_t m = work % hits, first = work / hits * kEach;
      const std::size_t end = first + kEach < voters(a) ? first + kEach : voters(a);
      atomic_add(a.votes.map + m, agreeing(a, m, first, end));
    }
  }
  PARLOC_HD static std::uint64_t agreeing(const WeightArgs& a, std::size_t m, std::size_t first,
                                          std::size_t end) {
    const Particles& p = a.rays.particles;
    std::uint64_t votes = 0;
    for (std::size_t i = first; i < end; ++i) {
      const SinCos h = portable_sincos(p.theta[i]);
      const float u0 = p.x[i] * a.rays.map.inv_resolution, v0 = p.y[i] * a.rays.map.inv_resolution;
      votes += agrees(a, u0, v0, h, m) ? 1 : 0;
    }
    return votes;
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
      if (phase == 1 && share == 0.0f) atomic_add(&shared.skipped, 1u);
      a.votes.map[m] = a.votes.unmapped[m] = 0;
    }
  }
};

}  // namespace

void FilterStages::beam_votes(const WeightArgs& args, Queue& queue) {
  constexpr std::size_t kUsualBeams = 128;  // more or fewer only change how often a thread comes round
  const std::size_t most = voters_of(args.model, args.rays.particles.capacity);
  if (args.model == SensorModel::class_conditional) {
    with_caster(args.rays, [&](auto caster) {
      launch_step(AskForClass<decltype(caster)>{args}, blocks_for(most * kUsualBeams), queue);
    });
  } else {
    const std::size_t groups = (most + AskForAgreement::kEach - 1) / AskForAgreement::kEach;
    launch_step(AskForAgreement{args}, blocks_for(groups * kUsualBeams), queue);
  }
  launch_step(Decide{args}, 1, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
