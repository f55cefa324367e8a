#include "common/ros/rigid_transform.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable64.h"

namespace parloc {

namespace {

/// The column of the rotation's matrix: where the axis of the child points to in the parent's frame.
std::array<double, 3> rotated(const RigidTransform& a, const std::array<double, 3>& v) {
  // v + 2 w (q x v) + 2 q x (q x v)
  const double tx = 2.0 * (a.qy * v[2] - a.qz * v[1]);
  const double ty = 2.0 * (a.qz * v[0] - a.qx * v[2]);
  const double tz = 2.0 * (a.qx * v[1] - a.qy * v[0]);
  return {v[0] + a.qw * tx + (a.qy * tz - a.qz * ty), v[1] + a.qw * ty + (a.qz * tx - a.qx * tz),
          v[2] + a.qw * tz + (a.qx * ty - a.qy * tx)};
}

}  // namespace

bool operator==(const RigidTransform& a, const RigidTransform& b) {
  return a.x_m == b.x_m && a.y_m == b.y_m && a.z_m == b.z_m && a.qx == b.qx && a.qy == b.qy && a.qz == b.qz &&
         a.qw == b.qw;
}

std::array<double, 3> transformed(const RigidTransform& a, const std::array<double, 3>& point) {
  const std::array<double, 3> r = rotated(a, point);
  return {a.x_m + r[0], a.y_m + r[1], a.z_m + r[2]};
}

RigidTransform compose(const RigidTransform& a, const RigidTransform& b) {
  const std::array<double, 3> at = transformed(a, {b.x_m, b.y_m, b.z_m});
  return {at[0],
          at[1],
          at[2],
          a.qw * b.qx + a.qx * b.qw + a.qy * b.qz - a.qz * b.qy,
          a.qw * b.qy - a.qx * b.qz + a.qy * b.qw + a.qz * b.qx,
          a.qw * b.qz + a.qx * b.qy - a.qy * b.qx + a.qz * b.qw,
          a.qw * b.qw - a.qx * b.qx - a.qy * b.qy - a.qz * b.qz};
}

RigidTransform inverse(const RigidTransform& a) {
  RigidTransform out{0.0, 0.0, 0.0, -a.qx, -a.qy, -a.qz, a.qw};
  const std::array<double, 3> at = rotated(out, {a.x_m, a.y_m, a.z_m});
  out.x_m = -at[0];
  out.y_m = -at[1];
  out.z_m = -at[2];
  return out;
}

bool normalise(RigidTransform& a) {
  const double length = std::sqrt(a.qx * a.qx + a.qy * a.qy + a.qz * a.qz + a.qw * a.qw);
  const bool finite = std::isfinite(a.x_m) && std::isfinite(a.y_m) && std::isfinite(a.z_m);
  if (!finite || !(std::fabs(length - 1.0) < 0.01)) return false;
  a.qx /= length;
  a.qy /= length;
  a.qz /= length;
  a.qw /= length;
  return true;
}

RigidTransform blend(const RigidTransform& a, const RigidTransform& b, double part) {
  if (a == b) return a;
  const double dot = a.qx * b.qx + a.qy * b.qy + a.qz * b.qz + a.qw * b.qw;
  const double u = 1.0 - part, v = dot < 0.0 ? -part : part;
  RigidTransform out{u * a.x_m + part * b.x_m, u * a.y_m + part * b.y_m, u * a.z_m + part * b.z_m,
                     u * a.qx + v * b.qx,      u * a.qy + v * b.qy,      u * a.qz + v * b.qz,
                     u * a.qw + v * b.qw};
  const double length = std::sqrt(out.qx * out.qx + out.qy * out.qy + out.qz * out.qz + out.qw * out.qw);
  out.qx /= length;
  out.qy /= length;
  out.qz /= length;
  out.qw /= length;
  return out;
}

Pose planar(const RigidTransform& a) {
  // A rotation about z alone is the usual case, and twice an angle the more precise way to it.
  const double yaw_rad =
      a.qx == 0.0 && a.qy == 0.0
          ? 2.0 * portable_atan2_64(a.qz, a.qw)
          : portable_atan2_64(2.0 * (a.qw * a.qz + a.qx * a.qy), 1.0 - 2.0 * (a.qy * a.qy + a.qz * a.qz));
  return {a.x_m, a.y_m, wrap64(yaw_rad)};
}

PlanarMount planar_mount(const RigidTransform& T_base_sensor) {
  PlanarMount mount;
  mount.T_base_sensor = planar(T_base_sensor);
  const double up = rotated(T_base_sensor, {0.0, 0.0, 1.0})[2];
  mount.upside_down = up < 0.0;
  mount.tilt_rad = std::acos(std::clamp(std::fabs(up), 0.0, 1.0));
  return mount;
}

}  // namespace parloc
