// What a step is told, in one piece of memory: one copy brings it to the backend's space, and the stages of a
// recorded step find it where it always is.
#pragma once

#include <cstdint>

#include "common/model/motion.h"
#include "common/model/ray_models.h"
#include "common/model/scan_shape.h"

namespace parloc {

/// Who draws random numbers in this step.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint32_t step = 0;
};

/// Everything that changes from step to step; the arrays of the beams lie behind it.
struct alignas(16) StepInput {
  MotionStep motion;
  RandomKey key;
  ScanShape scan;
  RayModels models;  ///< They depend on the maximum range.
  float tempering = 1.0f;
  std::uint32_t all_particles = 0;  ///< adapt: as many as there can be.
  float scan_worth = 0.0f;          ///< Independent beams that the scan counts for; 0: no scan.
};

}  // namespace parloc
