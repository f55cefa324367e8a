#include "common/filter/beam_votes.h"
#include "common/filter/trace_beam.h"
#include "common/math/fixed_point.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

constexpr unsigned kLanes = 32;  // threads per particle
constexpr unsigned kParticlesPerBlock = kThreads / kLanes;

PARLOC_HD std::int32_t ray_beam(const WeightArgs& a, const RayOrigin& o, std::size_t i, std::size_t m) {
  const Beams& beams = a.rays.beams;
  const float expected_m =
      a.rays.expected_m != nullptr ? a.rays.expected_m[i * beams.count + m] : trace_beam(a.rays, o, m);
  const float range_m = beams.range_m[m], constant = beams_for_model(a).short_density[m];
  const bool hit = m < beams.hits;
  return with_ray_model(a.models, a.model, [&](const auto& model) {
    return fixed_log_likelihood(hit ? model.hit(range_m, constant, expected_m)
                                    : model.miss(range_m, expected_m));
  });
}

PARLOC_HD std::int32_t field_beam(const WeightArgs& a, const FieldPose& pose, std::size_t m) {
  const Beams& beams = a.rays.beams;
  if (needs_beam_votes(a) && a.votes.share[m] == 0.0f) return 0;
  return a.field.value_at(a.field.place(pose, beams.end_x[m], beams.end_y[m]));
}

/// Sum of this lane's beams, m = lane, lane + 32, ...: integers, so the lanes may add up in any order.
PARLOC_HD std::int64_t lane_sum(const WeightArgs& a, std::size_t i, unsigned lane) {
  const Particles& particles = a.rays.particles;
  const Beams& beams = a.rays.beams;
  std::int64_t sum = 0;
  if (!casts_rays(a.model)) {
    const float cells_per_m = a.rays.map.inv_resolution;
    const FieldPose pose = a.field.pose(particles.x[i] * cells_per_m, particles.y[i] * cells_per_m,
                                        portable_sincos(particles.theta[i]));
    for (std::size_t m = lane; m < beams.hits; m += kLanes) sum += field_beam(a, pose, m);
    return sum;
  }
  const RayOrigin o = ray_origin(a.rays, i);
  for (std::size_t m = lane; m < beams.count; m += kLanes) sum += ray_beam(a, o, i, m);
  return sum;
}

struct WeightGroup {  // a block weighs kParticlesPerBlock particles
  struct Shared {
    std::uint64_t sum[kParticlesPerBlock];
  };
  static constexpr int kPhases = 3;
  WeightArgs args;
  std::size_t first;  // particle of block 0
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& shared) const {
    const unsigned slot = me.thread / kLanes, lane = me.thread % kLanes;
    const std::size_t i = first + std::size_t{me.block} * kParticlesPerBlock + slot;
    if (phase == 0 && lane == 0) shared.sum[slot] = 0;
    if (i >= args.rays.particles.count()) return;
    if (phase == 1)
      atomic_add(&shared.sum[slot], static_cast<std::uint64_t>(lane_sum(with_input(args), i, lane)));
    float& log_weight = args.rays.particles.log_weight[i];
    if (phase == 2 && lane == 0)
      log_weight = tempered_log_weight(log_weight, static_cast<std::int64_t>(shared.sum[slot]),
                                       sum_unit_nat(args), args.rays.input->tempering);
  }
};

}  // namespace

void FilterStages::weight(const WeightArgs& args, Queue& queue) {
  constexpr std::size_t kPerLaunch = std::size_t{kMaxBlocks} * kParticlesPerBlock;
  for (std::size_t first = 0; first < args.rays.particles.capacity; first += kPerLaunch) {
    const std::size_t here = std::min(kPerLaunch, args.rays.particles.capacity - first);
    launch(WeightGroup{args, first},
           static_cast<unsigned>((here + kParticlesPerBlock - 1) / kParticlesPerBlock), queue);
  }
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
