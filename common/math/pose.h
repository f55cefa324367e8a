// Planar poses in float64: what the host computes with and what users see.
#pragma once

namespace parloc {

/// A pose in the plane, or the rigid transform T_parent_child that it stands for.
struct Pose {
  double x_m = 0.0;        ///< Along the parent's x axis.
  double y_m = 0.0;        ///< And along its y axis.
  double theta_rad = 0.0;  ///< Counter-clockwise, 0 along +x, in [-pi, pi).
};

/// a (+) b: pose b, given in the frame of a, expressed in the parent frame of a (SPEC 0.1).
/// Deterministic on every machine: uses parloc's own sine and cosine.
Pose compose(const Pose& a, const Pose& b);

/// a (-) b: pose a seen from b (SPEC 0.1).
Pose relative(const Pose& a, const Pose& b);

/// compose(inverse(a), a) is the identity.
Pose inverse(const Pose& a);

/// Between their places.
double distance_m(const Pose& a, const Pose& b);

/// Whether all three are numbers.
bool is_finite(const Pose& pose);

/// Between their headings, 0 to pi.
double turn_rad(const Pose& a, const Pose& b);

/// `part` of the way from a to b, in a straight line and with the shorter turn; part 0 is exactly a.
Pose blend(const Pose& a, const Pose& b, double part);

/// Where a body is after `part` of a step, at constant speed and turn rate: on the circle (or line) from the
/// identity to `step`, which turns by less than half a turn. `part` may lie outside [0, 1]. Exactly the
/// identity for part 0 and for a step of nothing.
Pose along_arc(const Pose& step, double part);

/// A step at constant speed and turn rate: how far the body goes along its heading and to its side, and how
/// far it turns meanwhile.
struct ArcMotion {
  double ahead_m = 0.0;   ///< Along the body's own heading.
  double side_m = 0.0;    ///< To its left.
  double turn_rad = 0.0;  ///< Counter-clockwise.
};
/// The one that ends at `step`, which turns by less than half a turn.
ArcMotion arc_motion(const Pose& step);
/// Where it ends, seen from its start.
Pose arc_end(const ArcMotion& motion);

}  // namespace parloc
