// The true motion of a simulated robot: where it is at every time, exactly and without integration.
#pragma once

#include <vector>

#include "common/math/pose.h"
#include "common/simulator/scenario.h"

namespace parloc {

/// A stretch of time in which the robot stands, turns in place, or drives straight, at constant speed.
struct DrivePhase {
  double start_s = 0.0;
  double end_s = 0.0;
  Pose from;
  double turn_rad = 0.0;  ///< Signed; 0 unless it turns.
  double dx_m = 0.0;      ///< 0 unless it drives.
  double dy_m = 0.0;
};

struct Drive {
  std::vector<DrivePhase> phases;  ///< In time order, without gaps, from 0 s; never empty.
  double duration_s() const { return phases.back().end_s; }
};

/// Phases of a path: at each point pause, spin, turn the short way towards the next, drive there. The start
/// faces the second point. Needs at least two points, each apart from the one before. Deterministic on every
/// machine.
Drive plan_drive(const WaypointPath& path);

/// The pose at a time, held at both ends.
Pose pose_at(const Drive& drive, double time_s);

double path_length_m(const WaypointPath& path);

}  // namespace parloc
