// Poses over time.
#pragma once

#include <vector>

#include "common/math/pose.h"

namespace parloc {

struct StampedPose {
  double stamp_s = 0.0;
  Pose pose;
};
using Trajectory = std::vector<StampedPose>;  ///< In file order; stamps may run backwards.

}  // namespace parloc
