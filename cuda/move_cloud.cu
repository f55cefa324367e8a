#include "cuda/flow_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct MoveCloud {
  Particles p;
  const CloudMove* move;
  const FlowState* state;
  const StepInput* input;
  PARLOC_HD void operator()(const Thread& me) const {
    if (state->skip != FlowSkip::none) return;
    const RandomKey key = input->key;
    for (std::size_t i = me.first(); i < p.count(); i += me.stride())
      move_one(p.x[i], p.y[i], p.theta[i], *move, move->noisy, static_cast<std::uint32_t>(i), key.step,
               key.seed);
  }
};

}  // namespace

void FlowStages::move_cloud(const FlowArgs& args, Queue& queue) {
  launch(MoveCloud{args.particles, args.move, args.state, args.input}, blocks_for(args.particles.capacity),
         queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
