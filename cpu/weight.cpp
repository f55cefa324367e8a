#include <algorithm>
#include <atomic>

#include "common/filter/beam_votes.h"
#include "common/filter/weights/normalise.h"
#include "common/math/fixed_point.h"
#include "cpu/likelihood_sum.h"
#include "cpu/parallel.h"
#include "cpu/ray_scan.h"
#include "cpu/ray_trace.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

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

/// The particles of one thread, by a ray model: a few at a time, so that their rays can be followed together.
template <class Model>
class RayWeigher {
 public:
  RayWeigher(const WeightArgs& a, const RayScan<Model>& scan, Contest& contest)
      : a_(a), scan_(scan), contest_(contest), beams_(a.rays.beams.count), row_size_(row_size(beams_)) {}

  PARLOC_HD void weigh(std::size_t begin, std::size_t end) {
    const std::size_t together = particles_together(beams_);
    for (std::size_t i = begin; i < end; i += together) {
      const std::size_t count = together < end - i ? together : end - i;
      for (std::size_t k = 0; k < count; ++k) origins_[k] = ray_origin(a_.rays, i + k);
      on_.on.count = 0;
      for (std::size_t k = 0; k < count; ++k) begin_one(k, i + k);
      finish(i, count);
    }
  }

 private:
  /// The first leaps of particle i's rays, and the sum of beams that arrived; lost if it cannot win any more.
  void begin_one(std::size_t k, std::size_t i) {
    Partial& p = partial_[k];
    p = {0, on_.on.count, on_.on.count, false};
    const std::size_t row = k * row_size_;
    if (a_.rays.expected_m != nullptr) {
      std::copy_n(a_.rays.expected_m + i * beams_, beams_, rows_ + row);
      return add(p, row, 0, beams_);
    }
    if (a_.rays.caster != RayCaster::skip) {  // references, there to be compared with: they trace every beam
      trace_first(a_.rays, origins_[k], 0, beams_, rows_, row, on_);
      return add(p, row, 0, beams_);
    }
    if (nothing_in_reach(a_.rays, origins_[k])) {
      std::fill_n(rows_ + row, beams_, a_.rays.beams.range_max_m);
      return add(p, row, 0, beams_);
    }
    const float before = a_.rays.particles.log_weight[i];
    std::size_t first = 0;
    for (const auto& [last, most_behind] : scan_.looks()) {
      trace_first(a_.rays, origins_[k], first, last, rows_, row, on_);
      add(p, row, first, last);
      first = last;
      p.lost = contest_.lost(
          tempered_log_weight(before, p.sum + most_behind, kLogLikelihoodUnit_nat, a_.tempering));
      if (p.lost) on_.on.count = p.late_from;
      if (p.lost) return;
    }
    p.late_to = on_.on.count;
  }

  /// The rays that are still on their way, then all weights.
  void finish(std::size_t i, std::size_t count) {
    const std::size_t late = on_.on.count;
    if (late > 0) {
      std::copy_n(on_.on.place, late, places_);
      std::fill_n(places_ + late, kTogether, 0);
      trace_rest(a_.rays, rows_, on_);
    }
    float* log_weight = a_.rays.particles.log_weight + i;
    for (std::size_t k = 0; k < count; ++k) {
      Partial& p = partial_[k];
      if (p.late_to > p.late_from)
        run_simd([&]() PARLOC_SIMD_LOOP {
          p.sum += scan_.late_sum(rows_, k * row_size_, places_ + p.late_from, p.late_to - p.late_from);
        });
      log_weight[k] = p.lost
                          ? kNoWeight
                          : tempered_log_weight(log_weight[k], p.sum, kLogLikelihoodUnit_nat, a_.tempering);
      contest_.enter(log_weight[k]);
    }
  }

  struct Partial {
    std::int64_t sum;
    std::size_t late_from, late_to;  ///< Its rays in the queue.
    bool lost;
  };
  void add(Partial& p, std::size_t row, std::size_t first, std::size_t last) {
    run_simd([&]() PARLOC_SIMD_LOOP { p.sum += scan_.sum(rows_ + row, first, last); });
  }

  const WeightArgs& a_;
  const RayScan<Model>& scan_;
  Contest& contest_;
  const std::size_t beams_, row_size_;
  alignas(64) float rows_[kRangeRoom] = {};
  Travellers on_;
  std::int32_t places_[kRangeRoom];
  RayOrigin origins_[kMostTogether];
  Partial partial_[kMostTogether];
};

template <class Model>
void weight_by_rays(const WeightArgs& a, const Model& model, Workers& workers) {
  const RayScan<Model> scan(model, beams_for_model(a));
  Contest contest(a.rays.particles.capacity);
  const auto loop = [&](std::size_t begin, std::size_t end)
                        PARLOC_SIMD_LOOP { RayWeigher<Model>(a, scan, contest).weigh(begin, end); };
  parallel_blocks(a.rays.particles.count(), workers.threads, 1, loop);
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
