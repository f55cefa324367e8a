#include "cuda/stages.h"
#include "cuda/trace_beam.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct RayTrace {  // one thread per ray, adjacent threads adjacent beams
  using Shared = NoShared;
  static constexpr int kPhases = 1;
  RayTraceArgs a;
  PARLOC_HD void operator()(const Thread& me, int, Shared&) const {
    const std::size_t beams = a.beams.count;
    for (std::size_t r = me.first(); r < a.particles.count * beams; r += me.stride()) {
      const Origin o = sensor_origin(a.particles, a.beams, a.map, r / beams);
      a.expected_m[r] = trace_beam(a.map, a.beams, a.caster, a.fixed_step_cells, o, r % beams);
    }
  }
};

}  // namespace

void ray_trace(const RayTraceArgs& args, Stream stream) {
  launch(RayTrace{args}, blocks_for(args.particles.count * args.beams.count), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
