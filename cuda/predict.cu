#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct Predict {
  PredictArgs args;
  PARLOC_HD void operator()(const Thread& me) const {
    const Particles p = args.particles;
    const MotionStep motion = args.input->motion;
    const RandomKey key = args.input->key;
    const bool spread = widens(motion);
    const std::size_t count = p.count();
    for (std::size_t i = me.first(); i < count; i += me.stride()) {
      const std::uint32_t slot = static_cast<std::uint32_t>(i);
      predict_one(p.x[i], p.y[i], p.theta[i], motion, slot, key.step, key.seed);
      if (spread) spread_one(p.x[i], p.y[i], p.theta[i], motion, slot, key.step, key.seed);
      if (slips(motion, slot, key.step))
        slip_one(p.x[i], p.y[i], p.theta[i], motion, slot, key.step, key.seed);
    }
  }
};

}  // namespace

void FilterStages::predict(const PredictArgs& args, Queue& queue) {
  launch_step(Predict{args}, blocks_for(args.particles.capacity), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
