#include "common/simulator/wheel_odometry.h"

#include <cmath>

#include "common/math/portable64.h"

namespace parloc {

WheelArcs wheel_arcs(double along_m, double turn_rad, double wheel_base_m) {
  const double apart_m = 0.5 * wheel_base_m * turn_rad;
  return {along_m - apart_m, along_m + apart_m};
}

WheelArcs with_error(const WheelArcs& arcs, double kappa_m, double left, double right) {
  return {arcs.left_m + std::sqrt(kappa_m * std::fabs(arcs.left_m)) * left,
          arcs.right_m + std::sqrt(kappa_m * std::fabs(arcs.right_m)) * right};
}

Pose rolled(const Pose& from, const WheelArcs& arcs, double wheel_base_m) {
  const double along_m = 0.5 * (arcs.left_m + arcs.right_m);
  const double turn_rad = (arcs.right_m - arcs.left_m) / wheel_base_m;
  const SinCos64 middle = portable_sincos64(from.theta_rad + 0.5 * turn_rad);
  return {from.x_m + along_m * middle.cos, from.y_m + along_m * middle.sin,
          wrap64(from.theta_rad + turn_rad)};
}

double along_heading(const Pose& from, const Pose& to) {
  const double half_turn_rad = 0.5 * wrap64(to.theta_rad - from.theta_rad);
  const SinCos64 middle = portable_sincos64(from.theta_rad + half_turn_rad);
  return (to.x_m - from.x_m) * middle.cos + (to.y_m - from.y_m) * middle.sin;
}

}  // namespace parloc
