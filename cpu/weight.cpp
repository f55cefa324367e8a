#include <vector>

#include "common/math/fixed_point.h"
#include "common/model/beams.h"
#include "cpu/parallel.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

/// Sum over the beams of a ray model, hits and misses apart: two straight loops.
template <class Model>
PARLOC_HD std::int64_t sum_of_rays(const Model& model, const Beams& b, const float* expected_m) {
  std::int64_t sum = 0;
  for (std::size_t m = 0; m < b.hits; ++m)
    sum += fixed_log_likelihood(model.hit(b.range_m[m], b.short_density[m], expected_m[m]));
  for (std::size_t m = b.hits; m < b.count; ++m)
    sum += fixed_log_likelihood(model.miss(b.range_m[m], expected_m[m]));
  return sum;
}

/// Sum over the hits of the likelihood field at particle i.
template <bool kBilinear>
PARLOC_HD std::int64_t sum_of_end_points(const WeightArgs& a, std::size_t i) {
  const RayTraceArgs& r = a.rays;
  const LikelihoodField field = a.field;
  const float* __restrict end_x = r.beams.end_x;
  const float* __restrict end_y = r.beams.end_y;
  const SinCos h = portable_sincos(r.particles.theta[i]);
  const float u0 = r.particles.x[i] * r.map.inv_resolution;
  const float v0 = r.particles.y[i] * r.map.inv_resolution;
  std::int64_t sum = 0;
  for (std::size_t m = 0; m < r.beams.hits; ++m) {
    const float u = base_to_grid_x(u0, h.cos, h.sin, end_x[m], end_y[m]);
    const float v = base_to_grid_y(v0, h.cos, h.sin, end_x[m], end_y[m]);
    sum += fixed_log_likelihood(kBilinear ? field.bilinear(u, v) : field.nearest(u, v));
  }
  return sum;
}

template <class Model>
void weight_by_rays(const WeightArgs& a, const Model& model, Workers& workers) {
  const RayTraceArgs& r = a.rays;
  const float* stored_m = r.expected_m;
  float* log_weight = r.particles.log_weight;
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    alignas(64) float row[kMaxBeams];
    for (std::size_t i = begin; i < end; ++i) {
      if (stored_m == nullptr) trace_particle(r, i, row);
      const float* expected_m = stored_m != nullptr ? stored_m + i * r.beams.count : row;
      log_weight[i] =
          tempered_log_weight(log_weight[i], sum_of_rays(model, r.beams, expected_m), a.tempering);
    }
  };
  parallel_blocks(r.particles.count, workers.threads, 1, loop);
}

template <bool kBilinear>
void weight_by_field(const WeightArgs& a, Workers& workers) {
  float* log_weight = a.rays.particles.log_weight;
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t i = begin; i < end; ++i)
      log_weight[i] = tempered_log_weight(log_weight[i], sum_of_end_points<kBilinear>(a, i), a.tempering);
  };
  parallel_blocks(a.rays.particles.count, workers.threads, 1, loop);
}

}  // namespace

void weight(const WeightArgs& a, Workers& workers) {
  switch (a.model) {
    case SensorModel::gaussian:
      return weight_by_rays(a, a.gaussian, workers);
    case SensorModel::beam:
      return weight_by_rays(a, a.censored, workers);
    case SensorModel::likelihood_field:
      return a.lookup == FieldLookup::bilinear ? weight_by_field<true>(a, workers)
                                               : weight_by_field<false>(a, workers);
  }
}

}  // namespace parloc::cpu
