#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct Predict {
  Particles p;
  const StepInput* input;
  PARLOC_HD void operator()(const Thread& me) const {
    const MotionStep motion = input->motion;
    const RandomKey key = input->key;
    for (std::size_t i = me.first(); i < p.count; i += me.stride())
      predict_one(p.x[i], p.y[i], p.theta[i], motion, static_cast<std::uint32_t>(i), key.step, key.seed);
  }
};

}  // namespace

void predict(const Particles& particles, const StepInput* input, Stream stream) {
  launch(Predict{particles, input}, blocks_for(particles.count), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
