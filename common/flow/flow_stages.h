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

#include "common/flow/cloud_moments.h"
#include "common/flow/cloud_move.h"
#include "common/flow/flow_state.h"

namespace parloc {

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
