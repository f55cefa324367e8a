#include "common/filter/trace_beam.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct RayTrace {  // one thread per ray, adjacent threads adjacent beams
  RayTraceArgs args;
  PARLOC_HD void operator()(const Thread& me) const {
    const RayTraceArgs a = with_input(args);
    const std::size_t beams = a.beams.count;
    for (std::size_t r = me.first(); r < a.particles.count() * beams; r += me.stride()) {
      a.expected_m[r] = trace_beam(a, ray_origin(a, r / beams), r % beams);
    }
  }
};

}  // namespace

void FilterStages::ray_trace(const RayTraceArgs& args, Queue& queue) {
  launch_step(RayTrace{args}, blocks_for(args.particles.capacity * args.beams.count), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
