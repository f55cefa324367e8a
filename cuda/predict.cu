#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct Predict {
  Particles p;
  const StepInput* input;
  PARLOC_HD void operator()(const Thread& me) const {
    const MotionStep motion = input->motion;
    const RandomKey key = input->key;
    const bool spread = widens(motion);
    const std::size_t count = p.count();
    for (std::size_t i = me.first(); i < count; i += me.stride()) {
      const std::uint32_t slot = static_cast<std::uint32_t>(i);
      predict_one(p.x[i], p.y[i], p.theta[i], motion, slot, key.step, key.seed);
      if (spread) spread_one(p.x[i], p.y[i], p.theta[i], motion, slot, key.step, key.seed);
    }
  }
};

}  // namespace

void predict(const Particles& particles, const StepInput* input, Stream stream) {
  launch(Predict{particles, input}, blocks_for(particles.capacity), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
