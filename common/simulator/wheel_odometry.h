// Odometry of a robot with two driven wheels, and its error: every wheel's distance is uncertain with a
// variance that grows with it (Siegwart & Nourbakhsh 2004, section 5.2.4; SPEC 1.6).
#pragma once

#include "common/math/pose.h"

namespace parloc {

/// How far each wheel rolls in a step; negative backwards.
struct WheelArcs {
  double left_m = 0.0, right_m = 0.0;
};

/// Of a robot that drives `along_m` and turns by `turn_rad`.
WheelArcs wheel_arcs(double along_m, double turn_rad, double wheel_base_m);

/// With Gaussian errors of variance kappa * |distance|; `left` and `right` are standard normal.
WheelArcs with_error(const WheelArcs& arcs, double kappa_m, double left, double right);

/// Where they take the robot: mid-point integration, as wheel odometry does it.
Pose rolled(const Pose& from, const WheelArcs& arcs, double wheel_base_m);

/// The step's part along the heading half-way, which is what rolled() needs to get from one pose to the
/// other.
double along_heading(const Pose& from, const Pose& to);

}  // namespace parloc
