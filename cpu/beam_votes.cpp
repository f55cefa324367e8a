#include "common/filter/beam_votes.h"

#include <algorithm>

#include "common/math/atomics.h"
#include "cpu/ray_trace.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

void add_votes(std::uint64_t* to, const std::uint64_t* votes, std::size_t count) {
  for (std::size_t m = 0; m < count; ++m)
    if (votes[m] != 0) atomic_add(to + m, votes[m]);
}

/// How many particles agree with each hit.
void count_agreement(const WeightArgs& a, Workers& workers) {
  const RayTraceArgs& r = a.rays;
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    std::uint64_t votes[kMaxBeams];
    std::fill_n(votes, r.beams.hits, std::uint64_t{0});
    for (std::size_t i = begin; i < end; ++i) {
      const SinCos h = portable_sincos(r.particles.theta[i]);
      const float u0 = r.particles.x[i] * r.map.inv_resolution;
      const float v0 = r.particles.y[i] * r.map.inv_resolution;
      for (std::size_t m = 0; m < r.beams.hits; ++m) votes[m] += agrees(a, u0, v0, h, m) ? 1 : 0;
    }
    add_votes(a.votes.map, votes, r.beams.hits);
  };
  parallel_blocks(voters(a), workers.threads, 1, loop);
}

void vote_on_classes(const WeightArgs& a, Workers& workers) {
  const RayTraceArgs& r = a.rays;
  const Beams& b = r.beams;
  const ClassConditionalBeam model{a.models.censored};
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    alignas(64) float row[kRangeRoom];
    Travellers on;
    std::uint64_t map[kMaxBeams], unmapped[kMaxBeams];
    std::fill_n(map, b.hits, std::uint64_t{0});
    std::fill_n(unmapped, b.hits, std::uint64_t{0});
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = voter_slot(a, k);
      const float* expected_m = r.expected_m != nullptr ? r.expected_m + i * b.count : row;
      if (expected_m == row) {
        on.on.count = 0;
        const RayOrigin origin = ray_origin(r, i);
        trace_first(r, origin, 0, b.hits, row, 0, on);
        trace_rest(r, row, on);
      }
      const float w = weight_before(r.particles, i);
      for (std::size_t m = 0; m < b.hits; ++m) {
        const ClassVotes votes = class_votes(model, w, b.range_m[m], b.short_density[m], expected_m[m]);
        map[m] += static_cast<std::uint64_t>(votes.map);
        unmapped[m] += static_cast<std::uint64_t>(votes.unmapped);
      }
    }
    add_votes(a.votes.map, map, b.hits);
    add_votes(a.votes.unmapped, unmapped, b.hits);
  };
  parallel_blocks(voters(a), workers.threads, 1, loop);
}

/// Shares from votes; leaves the votes zero.
void decide(const WeightArgs& a) {
  const StrictFloat strict;
  const std::size_t count = a.rays.beams.count;
  std::uint64_t skipped = 0;
  for (std::size_t m = 0; m < count; ++m) {
    a.votes.share[m] = share_of_votes(a, m);
    skipped += a.votes.share[m] == 0.0f ? 1 : 0;
    a.votes.map[m] = a.votes.unmapped[m] = 0;
  }
  if (skips_nothing(a, skipped)) std::fill_n(a.votes.share, count, 1.0f);
}

}  // namespace

void FilterStages::beam_votes(const WeightArgs& args, Queue& workers) {
  const WeightArgs a = with_input(args);
  if (a.model == SensorModel::class_conditional)
    vote_on_classes(a, workers);
  else
    count_agreement(a, workers);
  decide(a);
}

}  // namespace parloc::cpu
