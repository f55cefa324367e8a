// Two trajectories of one drive in different frames, laid on each other.
#pragma once

#include <optional>

#include "common/io/trajectory.h"

namespace parloc {

/// The rigid transform that takes `truth` to where the sum of squared distances to the estimates' positions
/// is least (no scaling). The truth at each estimate's stamp is that of compare_tracks(). Nothing without two
/// different places to hold on to.
std::optional<Pose> best_alignment(const Trajectory& estimate, const Trajectory& truth);

/// Every pose seen from the frame that `T` leads to: compose(T, pose).
Trajectory transformed(const Pose& T, Trajectory track);

}  // namespace parloc
