// Where the search for a calibration starts.
#pragma once

#include <vector>

#include "common/calibrate/mount_residuals.h"
#include "common/calibrate/odometry_path.h"

namespace parloc {

/// From nothing: the delay and the scale of turns from headings alone, trying every delay up to 0.6 s; then
/// place, yaw and scale of drive from the hand-eye equation, which is linear in place and yaw over scale.
/// Robust against a third of wrong motions. Changes the path's scales.
Unknowns start_of(const std::vector<PairMotion>& pairs, OdometryPath& path);

}  // namespace parloc
