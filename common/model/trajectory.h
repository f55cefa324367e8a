// Poses over time.
#pragma once

#include <vector>

#include "common/math/pose.h"

namespace parloc {

/// A pose, and when it was so.
struct StampedPose {
  double stamp_s = 0.0;  ///< Time.
  Pose pose;             ///< Pose of the base, in the frame of the trajectory.
};
using Trajectory = std::vector<StampedPose>;  ///< In file order; stamps may run backwards.

}  // namespace parloc
