#include "cpu/stages.h"

namespace parloc::cpu {

void FilterStages::predict(const PredictArgs& args, Queue& workers) {
  const Particles p = args.particles;
  const MotionStep motion = args.input->motion;
  const RandomKey key = args.input->key;
  parallel_for(p.count(), workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    float* __restrict x = p.x;
    float* __restrict y = p.y;
    float* __restrict theta = p.theta;
    const auto noise = [=](std::size_t i) PARLOC_SIMD_LOOP {
      return motion_noise(static_cast<std::uint32_t>(i), key.step, key.seed);
    };
    if (motion.omni != 0)  // Asked once: a loop of one form is the faster one.
      for (std::size_t i = begin; i < end; ++i) predict_omni(x[i], y[i], theta[i], motion, noise(i));
    else
      for (std::size_t i = begin; i < end; ++i) predict_differential(x[i], y[i], theta[i], motion, noise(i));
    if (widens(motion))
      for (std::size_t i = begin; i < end; ++i)
        spread_one(x[i], y[i], theta[i], motion, static_cast<std::uint32_t>(i), key.step, key.seed);
    if (motion.slip_every > 0)
      for (std::size_t i = begin; i < end; ++i)
        if (slips(motion, static_cast<std::uint32_t>(i), key.step))
          slip_one(x[i], y[i], theta[i], motion, static_cast<std::uint32_t>(i), key.step, key.seed);
  });
}

}  // namespace parloc::cpu
