// How a kernel comes by the range that is expected of a beam: chosen when it is launched, so that the usual
// case carries no registers for the others.
#pragma once

#include "common/filter/trace_beam.h"
#include "cuda/stream.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// By the skip field, the usual case.
struct BySkipField {
  PARLOC_HD static float expected_m(const RayTraceArgs& a, const RayOrigin& o, std::size_t, std::size_t m) {
    const float range_max_m = a.beams.range_max_m, reach_cells = range_max_m * a.map.inv_resolution;
    return range_by_skip(a.map, ray_of_beam(a, o, m), reach_cells, range_max_m);
  }
};

/// Walls that are segments, the casters that are there to be compared with, and what ray_trace has stored.
struct ByAny {
  PARLOC_HD static float expected_m(const RayTraceArgs& a, const RayOrigin& o, std::size_t i, std::size_t m) {
    return a.expected_m != nullptr ? a.expected_m[i * a.beams.count + m] : trace_beam(a, o, m);
  }
};

/// use(BySkipField{}) or use(ByAny{}).
template <class Use>
void with_caster(const RayTraceArgs& a, const Use& use) {
  if (a.caster == RayCaster::skip && a.map.walls.count == 0 && a.expected_m == nullptr)
    use(BySkipField{});
  else
    use(ByAny{});
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
