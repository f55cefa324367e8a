// A place where the robot may be.
#pragma once

#include "common/math/pose.h"

namespace parloc {

/// In the map frame, with its spread and how much speaks for it.
struct PoseGuess {
  Pose pose;                     ///< The middle of it.
  double sigma_xy_m = 0.0;       ///< Standard deviation along x, and along y.
  double sigma_theta_rad = 0.0;  ///< And of the heading.
  double weight = 1.0;           ///< Relative to the others; above 0.
};

/// That the wheels have slipped: where the robot is then, as a Gaussian about where they say that it is, and
/// how likely that is against that they have not.
struct SlipPrior {
  Pose expected;           ///< Map frame.
  double sigma_m = 0.3;    ///< Standard deviation of the place, along x and y.
  double sigma_rad = 0.2;  ///< And of the heading.
  double odds = 0.01;      ///< That they have slipped, against that they have not.
};

}  // namespace parloc
