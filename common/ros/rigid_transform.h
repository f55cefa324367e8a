// Rigid transforms in space, as ROS messages hold them.
#pragma once

#include <array>

#include "common/math/pose.h"

namespace parloc {

/// T_parent_child: where the child's frame is, seen from the parent's.
struct RigidTransform {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;
  double qx = 0.0, qy = 0.0, qz = 0.0, qw = 1.0;  ///< Of unit length.
};

RigidTransform compose(const RigidTransform& a, const RigidTransform& b);
RigidTransform inverse(const RigidTransform& a);
/// `part` of the way from a to b: straight, and by the shorter turn (normalised sum of the quaternions).
/// Exactly a where both are equal.
RigidTransform blend(const RigidTransform& a, const RigidTransform& b, double part);
/// The point of the child's frame in the parent's.
std::array<double, 3> transformed(const RigidTransform& a, const std::array<double, 3>& point);
/// With a quaternion of unit length; false if there is none near, or something is not finite.
bool normalise(RigidTransform& a);
/// Seen from above: place, and heading of the child's x axis.
Pose planar(const RigidTransform& a);

bool operator==(const RigidTransform& a, const RigidTransform& b);

/// Where a LiDAR sits, for a planar scan.
struct PlanarMount {
  Pose T_base_sensor;
  bool upside_down = false;  ///< Angles run clockwise seen from above.
  double tilt_rad = 0.0;     ///< Between the scan's plane and the floor.
};
PlanarMount planar_mount(const RigidTransform& T_base_sensor);

}  // namespace parloc
