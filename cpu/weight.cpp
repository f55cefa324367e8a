#include <vector>

#include "common/math/fixed_point.h"
#include "common/model/beams.h"
#include "cpu/parallel.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

/// Sum over the beams of a ray model, hits and misses apart: two straight loops.
template <class Model>
PARLOC_HD std::int64_t sum_beams(const Model& model, const Beams& b, const float* expected_m) {
  std::int64_t sum = 0;
  for (std::size_t m = 0; m < b.hits; ++m)
    sum += fixed_log_likelihood(model.hit(b.range_m[m], b.short_density[m], expected_m[m]));
  for (std::size_t m = b.hits; m < b.count; ++m)
    sum += fixed_log_likelihood(model.miss(b.range_m[m], expected_m[m]));
  return sum;
}

template <class Model>
void weight_by_rays(const WeightArgs& a, const Model& model, Workers& workers) {
  const RayTraceArgs rays{a.particles, a.map, a.beams, a.caster, a.fixed_step_cells, nullptr};
  parallel_blocks(
      a.particles.count, workers.threads, 1, [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
        alignas(64) float row[kMaxBeams];
        for (std::size_t i = begin; i < end; ++i) {
          const float* expected_m = a.expected_m != nullptr ? a.expected_m + i * a.beams.count : row;
          if (a.expected_m == nullptr) trace_particle(rays, i, row);
          float& log_weight = a.particles.log_weight[i];
          log_weight = tempered_log_weight(log_weight, sum_beams(model, a.beams, expected_m), a.tempering);
        }
      });
}

template <bool kBilinear>
void weight_by_field(const WeightArgs& a, Workers& workers) {
  parallel_blocks(a.particles.count, workers.threads, 1,
                  [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
                    const LikelihoodField field = a.field;
                    const float* __restrict end_x = a.beams.end_x;
                    const float* __restrict end_y = a.beams.end_y;
                    for (std::size_t i = begin; i < end; ++i) {
                      const SinCos h = portable_sincos(a.particles.theta[i]);
                      const float u0 = a.particles.x[i] * a.map.inv_resolution;
                      const float v0 = a.particles.y[i] * a.map.inv_resolution;
                      std::int64_t sum = 0;
                      for (std::size_t m = 0; m < a.beams.hits; ++m) {
                        const float u = base_to_grid_x(u0, h.cos, h.sin, end_x[m], end_y[m]);
                        const float v = base_to_grid_y(v0, h.cos, h.sin, end_x[m], end_y[m]);
                        sum += fixed_log_likelihood(kBilinear ? field.bilinear(u, v) : field.nearest(u, v));
                      }
                      float& log_weight = a.particles.log_weight[i];
                      log_weight = tempered_log_weight(log_weight, sum, a.tempering);
                    }
                  });
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
