#include "cpu/flow_stages.h"

namespace parloc::cpu {

void FlowStages::move_cloud(const FlowArgs& args, Queue& workers) {
  if (args.state->skip != FlowSkip::none) return;
  const Particles p = args.particles;
  const CloudMove& move = *args.move;
  const RandomKey key = args.input->key;
  parallel_for(p.count(), workers.threads, [=, &move](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    float* __restrict x = p.x;
    float* __restrict y = p.y;
    float* __restrict theta = p.theta;
    const CloudMove m = move;
    if (m.noisy)
      for (std::size_t i = begin; i < end; ++i)
        move_one(x[i], y[i], theta[i], m, true, static_cast<std::uint32_t>(i), key.step, key.seed);
    else
      for (std::size_t i = begin; i < end; ++i)
        move_one(x[i], y[i], theta[i], m, false, static_cast<std::uint32_t>(i), key.step, key.seed);
  });
}

}  // namespace parloc::cpu
