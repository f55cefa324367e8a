#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct Predict {
  PredictArgs a;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t i = me.first(); i < a.particles.count; i += me.stride())
      predict_one(a.particles.x[i], a.particles.y[i], a.particles.theta[i], a.motion,
                  static_cast<std::uint32_t>(i), a.key.step, a.key.seed);
  }
};

}  // namespace

void predict(const PredictArgs& args, Stream stream) {
  launch(Predict{args}, blocks_for(args.particles.count), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
