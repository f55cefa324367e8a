// THE STAGES OF FLOW AND KALMAN FILTERS, under the same names in cpu/ (OpenMP) and cuda/ (kernels), over the
// functions of common/flow, so that every result has the same bits on both. What changes from step to step
// they read from the input and the state when they run, as those of common/filter/stages.h.
//
// clang-format off
// | stage          | reads                              | writes                                                    |
// |----------------|------------------------------------|-----------------------------------------------------------|
// | distance_table | squared distances of the map       | the table that end points are looked up in                |
// | predict        | poses, motion                      | poses (common/filter/stages.h; not for pfpf)              |
// | cloud_moments  | poses, weights or none             | FlowState::cloud                                          |
// | predict_mean   | FlowState, motion                  | FlowState: prior, centre                                  |
// | reject_beams   | FlowState, scan, field             | which beams count (only with a z score)                   |
// | update_mean    | FlowState, scan, field             | FlowState: posterior; CloudMove                           |
// | move_cloud     | poses, CloudMove                   | poses (edh, naedh, gromov)                                |
// | flow_particles | poses, FlowState, scan, field      | poses (ledh); poses, log_weight (pfpf)                    |
// | finish_update  | FlowState                          | FlowState: posterior, from what the particles became      |
// clang-format on
#pragma once

#include "common/filter/weights/moments.h"
#include "common/flow/cloud_move.h"
#include "common/flow/flow_state.h"

namespace parloc {

// Mean and covariance of particles, with weights or without: terms of sums in the fixed shape
// (common/math/block_sum.h; SPEC 4).
constexpr int kCloudMeanSums = 4;        // x, y, sin, cos
constexpr int kCloudCovarianceSums = 6;  // xx, xy, xt, yy, yt, tt

/// The particles that sums run over. `weight` null: all weigh the same.
struct Cloud {
  Particles particles;
  const std::uint64_t* weight = nullptr;

  PARLOC_HD double weight_of(std::size_t i) const {
    return weight != nullptr ? static_cast<double>(weight[i]) : 1.0;
  }
  PARLOC_HD SumVector<kCloudMeanSums> mean_terms_of(std::size_t i) const {
    const Particles& p = particles;
    const double w = weight_of(i);
    const SinCos a = portable_sincos(p.theta[i]);
    return {{w * p.x[i], w * p.y[i], w * static_cast<double>(a.sin), w * static_cast<double>(a.cos)}};
  }
  PARLOC_HD SumVector<kCloudCovarianceSums> covariance_terms_of(std::size_t i, const Moments& m) const {
    const Particles& p = particles;
    const double w = weight_of(i);
    const double x = p.x[i] - m.x, y = p.y[i] - m.y, t = wrap64(p.theta[i] - m.theta);
    return {{w * (x * x), w * (x * y), w * (x * t), w * (y * y), w * (y * t), w * (t * t)}};
  }
};

/// Of all stages but cloud_moments.
struct FlowArgs {
  DistanceField field;
  FlowRules rules;
  Particles particles{};  ///< None for Kalman filters.
  const StepInput* input = nullptr;
  FlowState* state = nullptr;
  CloudMove* move = nullptr;
};

struct CloudMomentsArgs {
  Cloud cloud;
  const StepState* weighed = nullptr;  ///< Null: all particles weigh the same.
  bool covariance = false;             ///< Or the mean alone.
  FlowState* state = nullptr;
};

}  // namespace parloc
