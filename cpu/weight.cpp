#include <array>
#include <atomic>
#include <optional>

#include "common/filter/beam_votes.h"
#include "common/filter/weights/normalise.h"
#include "common/math/fixed_point.h"
#include "cpu/likelihood_sum.h"
#include "cpu/parallel.h"
#include "cpu/ray_trace.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

/// By masks, without a choice that would keep the loops below out of vectors.
PARLOC_HD std::int32_t known_or_most(float expected_m, std::int32_t known, std::int32_t most) {
  const std::int32_t is_known = -static_cast<std::int32_t>(expected_m >= 0.0f);
  return (known & is_known) | (most & ~is_known);
}

/// Sum over beams [first, last) of a ray model, hits and misses apart: two straight loops. A range that is
/// not known yet counts as the best one, `most`.
template <class Model>
PARLOC_HD std::int64_t sum_of_rays(const Model& model, const Beams& b, const std::int32_t* most,
                                   const float* expected_m, std::size_t first, std::size_t last) {
  const std::size_t hits = last < b.hits ? last : b.hits;
  std::int64_t sum = 0;
  for (std::size_t m = first; m < hits; ++m) {
    const std::int32_t known =
        fixed_log_likelihood(model.hit(b.range_m[m], b.short_density[m], expected_m[m]));
    sum += known_or_most(expected_m[m], known, most[m]);
  }
  for (std::size_t m = first > hits ? first : hits; m < last; ++m) {
    const std::int32_t known = fixed_log_likelihood(model.miss(b.range_m[m], expected_m[m]));
    sum += known_or_most(expected_m[m], known, most[m]);
  }
  return sum;
}

constexpr std::size_t kChunk = 32;  // beams after which a particle is looked at

/// What is known of the best particle while the others are weighed. Which of them saw it in time to give up
/// depends on the threads' schedule; the outcome does not, for only those give up whose weight is zero
/// anyway.
class Contest {
 public:
  explicit Contest(std::size_t particles)
      : lead_(static_cast<float>(weight_bits(particles) + 1) * 0.693147181f + 0.1f) {}
  /// Whether a particle that can reach no more than this gets weight zero.
  bool lost(float most) const { return most < best_.load(std::memory_order_relaxed) - lead_; }
  void enter(float log_weight) {
    float best = best_.load(std::memory_order_relaxed);
    while (best < log_weight && !best_.compare_exchange_weak(best, log_weight, std::memory_order_relaxed)) {
    }
  }

 private:
  float lead_;  // below the best by this, exp rounds to 0 in fixed point
  std::atomic<float> best_{-__builtin_inff()};
};

/// The most that beams can add to a particle's sum, whatever it expects.
struct Most {
  std::array<std::int32_t, kMaxBeams> of;                       ///< Each beam.
  std::array<std::int64_t, kMaxBeams / kChunk> of_those_after;  ///< All behind chunk c.

  template <class Model>
  Most(const Model& model, const Beams& b) {
    for (std::size_t m = 0; m < b.count; ++m)
      of[m] = fixed_log_likelihood(m < b.hits ? model.most_of_hit(b.range_m[m], b.short_density[m])
                                              : model.most_of_miss());
    std::int64_t sum = 0;
    for (std::size_t c = (b.count + kChunk - 1) / kChunk; c-- > 0;) {
      of_those_after[c] = sum;
      for (std::size_t m = c * kChunk; m < b.count && m < (c + 1) * kChunk; ++m) sum += of[m];
    }
  }
};

/// Ranges of one particle into `row`, as long as it may win; false if it cannot any more. `sum` of its beams
/// where it comes along.
template <class Model>
bool trace_while_open(const WeightArgs& a, const Model& model, const Beams& beams, std::size_t i,
                      const RayOrigin& origin, const Most& most, const Contest& contest, float* row,
                      Travellers& on, std::optional<std::int64_t>& sum) {
  const float before = a.rays.particles.log_weight[i];
  on.on.count = 0;
  if (a.rays.caster != RayCaster::skip) {  // references, there to be compared with: they trace every beam
    trace_first(a.rays, origin, 0, beams.count, row, on);
    return true;
  }
  if (nothing_in_reach(a.rays, origin)) {
    for (std::size_t m = 0; m < beams.count; ++m) row[m] = beams.range_max_m;
    return true;
  }
  std::int64_t so_far = 0;
  for (std::size_t first = 0; first < beams.count; first += kChunk) {
    const std::size_t last = first + kChunk < beams.count ? first + kChunk : beams.count;
    trace_first(a.rays, origin, first, last, row, on);
    run_simd([&]()
                 PARLOC_SIMD_LOOP { so_far += sum_of_rays(model, beams, most.of.data(), row, first, last); });
    if (contest.lost(tempered_log_weight(before, so_far + most.of_those_after[first / kChunk],
                                         kLogLikelihoodUnit_nat, a.tempering)))
      return false;
  }
  if (on.on.count == 0)
    sum = so_far;
  else
    trace_rest(a.rays, origin, row, on);
  return true;
}

constexpr std::size_t kOrigins = 64;  // particles made ready for their rays at a time

template <class Model>
void weight_by_rays(const WeightArgs& a, const Model& model, Workers& workers) {
  const RayTraceArgs& r = a.rays;
  const Beams beams = beams_for_model(a);
  const float* stored_m = r.expected_m;
  float* log_weight = r.particles.log_weight;
  const Most most(model, beams);
  Contest contest(r.particles.capacity);
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    alignas(64) float row[kRangeRoom];
    Travellers on;
    RayOrigin origins[kOrigins];
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t k = (i - begin) % kOrigins;
      if (k == 0)
        for (std::size_t n = 0; n < kOrigins && i + n < end; ++n) origins[n] = ray_origin(r, i + n);
      std::optional<std::int64_t> sum;
      if (stored_m == nullptr &&
          !trace_while_open(a, model, beams, i, origins[k], most, contest, row, on, sum)) {
        log_weight[i] = kNoWeight;
        continue;
      }
      const float* expected_m = stored_m != nullptr ? stored_m + i * beams.count : row;
      if (!sum) sum = sum_of_rays(model, beams, most.of.data(), expected_m, 0, beams.count);
      log_weight[i] = tempered_log_weight(log_weight[i], *sum, kLogLikelihoodUnit_nat, a.tempering);
      contest.enter(log_weight[i]);
    }
  };
  parallel_blocks(r.particles.count(), workers.threads, 1, loop);
}

void weight_by_field(const WeightArgs& a, Workers& workers) {
  const EndPoints ends(a);
  const Particles& p = a.rays.particles;
  const float cells_per_m = a.rays.map.inv_resolution;
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    FieldNotes notes(ends);
    const LikelihoodField field = a.field;
    for (std::size_t i = begin; i < end; ++i) {
      const FieldPose pose =
          field.pose(p.x[i] * cells_per_m, p.y[i] * cells_per_m, portable_sincos(p.theta[i]));
      const std::int32_t sum = field_sum(field, pose, ends, notes);
      p.log_weight[i] = tempered_log_weight(p.log_weight[i], sum, field.unit_nat, a.tempering);
    }
  };
  parallel_blocks(p.count(), workers.threads, 1, loop);
}

}  // namespace

void FilterStages::weight(const WeightArgs& args, Queue& workers) {
  const WeightArgs a = with_input(args);
  if (casts_rays(a.model))
    return with_ray_model(a.models, a.model, [&](const auto& model) { weight_by_rays(a, model, workers); });
  weight_by_field(a, workers);
}

}  // namespace parloc::cpu
