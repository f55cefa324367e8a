// The hand-eye equation of a calibration: what is left of it for each motion, and how that changes.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/calibrate/odometry_path.h"
#include "common/calibrate/scan_motions.h"
#include "common/calibrate/small_solver.h"

namespace parloc {

/// Places of the unknowns; the scales as logarithms.
inline constexpr std::size_t kX = 0, kY = 1, kYaw = 2, kDrive = 3, kTurn = 4, kDelay = 5, kDrift = 6,
                             kSide = 7;
using Unknowns = std::array<double, 8>;

/// How the sensor moved, in its own frame as it is mounted.
struct PairMotion {
  double from_s, to_s;
  Pose step;
  Matrix3 covariance;
};

/// The usable motions of a LiDAR, if it is mounted on that side.
std::vector<PairMotion> pair_motions(const LidarMotions& lidar, bool upside_down);

/// Along the heading half-way, to its side, and of the turn [m, m, rad], in the odometry's own units.
struct Residual {
  std::array<double, 3> error;
  Matrix3 covariance;  ///< What the match of the scans has in it.
  double ways, turns;  ///< How far the base went and turned, in steps between key scans.
};

/// Changes the path's scales. `omni`: the scale to the side is an unknown of its own, else that of the drive.
std::vector<Residual> residuals_at(const std::vector<PairMotion>& pairs, OdometryPath& path,
                                   const Unknowns& at, bool omni);

/// By unknown and motion; empty for those that are not free. Central differences: that by the delay is taken
/// over at least a period of the odometry, so that its noise pulls to neither side.
using Derivatives = std::array<std::vector<std::array<double, 3>>, 8>;
Derivatives derivatives_at(const std::vector<PairMotion>& pairs, OdometryPath& path, const Unknowns& at,
                           const std::array<bool, 8>& free);

}  // namespace parloc
