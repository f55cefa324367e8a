// A place where the robot may be.
#pragma once

#include "common/math/pose.h"

namespace parloc {

/// In the map frame, with its spread and how much speaks for it.
struct PoseGuess {
  Pose pose;
  double sigma_xy_m = 0.0, sigma_theta_rad = 0.0;
  double weight = 1.0;  ///< Relative to the others; above 0.
};

/// That the wheels have slipped: where the robot is then, as a Gaussian about where they say that it is, and
/// how likely that is against that they have not.
struct SlipPrior {
  Pose expected;  ///< Map frame.
  double sigma_m = 0.3, sigma_rad = 0.2;
  double odds = 0.01;
};

}  // namespace parloc
