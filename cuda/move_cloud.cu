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

void move_cloud(const Particles& particles, const CloudMove* move, const FlowState* state,
                const StepInput* input, Stream stream) {
  launch(MoveCloud{particles, move, state, input}, blocks_for(particles.capacity), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
