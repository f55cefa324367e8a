#include "common/filter/beam_votes.h"
#include "common/math/fixed_point.h"
#include "cuda/casters.h"
#include "cuda/largest_weight.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

constexpr unsigned kLanes = 32;  // a warp weighs one particle or a few
constexpr unsigned kWarps = kThreads / kLanes;
constexpr unsigned kMostPerWarp = 4;

/// What a beam says by a model of its range.
template <SensorModel kModel, class Caster>
struct RayBeam {
  using Origin = RayOrigin;
  PARLOC_HD static std::size_t count(const Beams& beams) { return beams.count; }
  PARLOC_HD static Origin origin(const WeightArgs& a, std::size_t i) { return ray_origin(a.rays, i); }
  PARLOC_HD static std::int32_t value(const WeightArgs& a, const Origin& o, std::size_t i, std::size_t m) {
    const Beams& beams = a.rays.beams;
    const float expected_m = Caster::expected_m(a.rays, o, i, m), range_m = beams.range_m[m];
    return with_ray_model(a.models, kModel, [&](const auto& model) {
      return fixed_log_likelihood(m < beams.hits ? model.hit(range_m, beams.short_density[m], expected_m)
                                                 : model.miss(range_m, expected_m));
    });
  }
};

/// By the likelihood field; `kVotes`: some beams may be left out.
template <bool kVotes>
struct FieldBeam {
  using Origin = FieldPose;
  PARLOC_HD static std::size_t count(const Beams& beams) { return beams.hits; }
  PARLOC_HD static Origin origin(const WeightArgs& a, std::size_t i) {
    const Particles& p = a.rays.particles;
    const float cells_per_m = a.rays.map.inv_resolution;
    return a.field.pose(p.x[i] * cells_per_m, p.y[i] * cells_per_m, portable_sincos(p.theta[i]));
  }
  PARLOC_HD static std::int32_t value(const WeightArgs& a, const Origin& o, std::size_t, std::size_t m) {
    if (kVotes && a.votes.share[m] == 0.0f) return 0;
    const Beams& beams = a.rays.beams;
    return a.field.value_at(a.field.place(o, beams.end_x[m], beams.end_y[m]));
  }
};

/// Lane after lane takes the next beam, from the first of a warp's particles to the last of its last: no lane
/// waits where a scan is no multiple of 32. Integers, so that lanes may add up in any order.
template <class Beam>
struct WeighParticles {
  struct Shared {
    typename Beam::Origin origin[kWarps * kMostPerWarp];
    std::int64_t sum[kWarps * kMostPerWarp][kLanes];
    std::uint32_t largest;
    bool last;
  };
  static constexpr int kPhases = 5;
  WeightArgs args;
  unsigned per_warp;  // particles; 1 to kMostPerWarp
  LargestOfBlocks result;
  std::uint32_t* arrived;

  PARLOC_HD int join_phase() const { return 4; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const std::size_t first = std::size_t{me.block} * here();
    if (phase == 0) prepare(me.thread, first, s);
    if (phase == 1) add_up(me.thread, first, s);
    if (phase == 2) finish(me.thread, first, s);
    if (phase == 3 && me.thread == 0) result.enter(s.largest);
    if (phase == 4 && me.thread == 0) result.take();
  }

 private:
  PARLOC_HD unsigned here() const { return kWarps * per_warp; }

  PARLOC_HD void prepare(unsigned t, std::size_t first, Shared& s) const {
    if (t == 0) s.largest = LargestWeight::kNone;
    for (unsigned p = 0; p < per_warp; ++p) s.sum[t / kLanes * per_warp + p][t % kLanes] = 0;
    if (t < here() && first + t < args.rays.particles.count())
      s.origin[t] = Beam::origin(with_input(args), first + t);
  }
  PARLOC_HD void add_up(unsigned t, std::size_t first, Shared& s) const {
    const unsigned lane = t % kLanes;
    const WeightArgs a = with_input(args);
    const std::uint32_t beams = static_cast<std::uint32_t>(Beam::count(a.rays.beams));
    const std::size_t particles = a.rays.particles.count();
    unsigned slot = t / kLanes * per_warp;
    const unsigned end = slot + per_warp;
    if (beams == 0) return;
    std::int64_t sum = 0;
    for (std::uint32_t m = lane;; m += kLanes) {
      while (m >= beams) {  // on to the next particle
        m -= beams;
        s.sum[slot++][lane] = sum;
        sum = 0;
        if (slot == end) return;
      }
      if (first + slot >= particles) return;
      sum += Beam::value(a, s.origin[slot], first + slot, m);
    }
  }
  PARLOC_HD void finish(unsigned t, std::size_t first, Shared& s) const {
    const Particles& particles = args.rays.particles;
    const std::size_t i = first + t;
    if (t >= here() || i >= particles.count()) return;
    std::int64_t sum = 0;
    for (unsigned k = 0; k < kLanes; ++k) sum += s.sum[t][(k + t) % kLanes];  // each thread at another bank
    const float log_weight =
        tempered_log_weight(particles.log_weight[i], sum, sum_unit_nat(args), args.rays.input->tempering);
    particles.log_weight[i] = log_weight;
    atomic_raise(&s.largest, ordered(valid_log_weight(log_weight)));
  }
};

/// Few particles are spread over all of the device; of many, a warp takes several.
unsigned particles_per_warp(std::size_t particles) {
  constexpr std::size_t kWarpsThatFillADevice = 8192;
  unsigned per_warp = kMostPerWarp;
  while (per_warp > 1 && particles / per_warp < kWarpsThatFillADevice) per_warp /= 2;
  return per_warp;
}

template <class Beam>
void weigh(WeightArgs args, Queue& queue) {
  const std::size_t particles = args.rays.particles.capacity;
  const unsigned per_warp = particles_per_warp(particles), each = kWarps * per_warp;
  args.rays.beams = beams_for_model(args);
  launch_step(
      WeighParticles<Beam>{args, per_warp, {queue.scratch.largest.data()}, queue.scratch.arrived.data()},
      static_cast<unsigned>((particles + each - 1) / each), queue);
}

template <SensorModel kModel>
void weigh_by_rays(const WeightArgs& args, Queue& queue) {
  with_caster(args.rays, [&](auto caster) { weigh<RayBeam<kModel, decltype(caster)>>(args, queue); });
}

}  // namespace

PARLOC_EVERY_CASE
void FilterStages::weight(const WeightArgs& args, Queue& queue) {
  using enum SensorModel;
  switch (args.model) {
    case gaussian:
      return weigh_by_rays<gaussian>(args, queue);
    case s5:
      return weigh_by_rays<s5>(args, queue);
    case beam:
      return weigh_by_rays<beam>(args, queue);
    case class_conditional:
      return weigh_by_rays<class_conditional>(args, queue);
    case likelihood_field:
    case likelihood_field_prob:
      return needs_beam_votes(args) ? weigh<FieldBeam<true>>(args, queue)
                                    : weigh<FieldBeam<false>>(args, queue);
  }
}
PARLOC_EVERY_CASE_END

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
