// A scan as short pieces of wall, for matching scans without a pull towards where they were.
#pragma once

#include <functional>
#include <vector>

#include "common/calibrate/small_solver.h"
#include "common/math/pose.h"
#include "common/model/lidar.h"
#include "common/model/scan.h"

namespace parloc {

/// The middle of some neighbouring beams' ends that lie on a line, and the line's normal.
struct WallPiece {
  double x_m, y_m, normal_x, normal_y;
  double normal_variance;  ///< Of the normal's direction [rad^2].
};

struct LineScan {
  std::vector<WallPiece> pieces;     ///< By ascending bearing, at most kMostPieces.
  std::vector<double> bearings_rad;  ///< Of their middles, -pi to pi.
  static constexpr std::size_t kMostPieces = 360;
};

/// In the sensor's own frame, by the angles that the scan states: of a LiDAR that is upside down it is a
/// mirror image. `moved`, if any: where the sensor is at a time relative to the scan's stamp, seen from where
/// it is at the stamp, in that same frame. Misses, what is masked and ends that lie on no line are left out.
LineScan line_scan(const Scan& scan, const LidarSetup& setup,
                   const std::function<Pose(double time_s)>& moved = {});

/// How one scan lies in another one's frame.
struct LineMatch {
  Pose step;
  Matrix3 covariance{};  ///< Of x, y [m^2] and the heading, in the frame of `step`'s own base.
  double share = 0.0;    ///< Of the pieces of the scan with fewer, those that lie on a wall of the other.
  double rms_m = 0.0;    ///< Of these, across the walls.
  std::size_t pieces = 0;
  /// Enough of both see the same walls for it to count.
  bool fits() const { return pieces >= kFewest && share >= kLeastShare; }
  static constexpr std::size_t kFewest = 12;
  static constexpr double kLeastShare = 0.5;
};

/// From `guess`, the step that brings the pieces of `moved` onto those of `reference`: point to line (Censi
/// 2008), with the mean of both normals (Rusinkiewicz 2019), so that neither scan is preferred.
/// Deterministic on every machine.
LineMatch match_lines(const LineScan& reference, const LineScan& moved, const Pose& guess);

}  // namespace parloc
