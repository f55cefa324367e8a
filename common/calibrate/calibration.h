// A calibration from a log: everything from its records to the numbers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/calibrate/mount_fit.h"
#include "common/calibrate/scan_motions.h"

namespace parloc {

struct LidarCalibration {
  std::string name;
  Mount stated;
  MountFit fit;
  std::size_t scans = 0, keys = 0;
};

struct LogCalibration {
  std::vector<LidarCalibration> lidars;
  bool omni = false;                        ///< The odometry drives sideways.
  double driven_m = 0.0, turned_rad = 0.0;  ///< By the odometry.
  /// Of all LiDARs together: drive, turn, delay, drift and side, in the places that Unknown gives them.
  std::array<Estimate1, kUnknowns> odometry{};
  const Estimate1& operator[](Unknown u) const { return odometry[static_cast<std::size_t>(u)]; }
};

/// What all that was added says. Scans are matched twice more, from what the first look gave. `keep_going`
/// is told the fraction; false ends the work with what there is.
/// `omni`: the robot is known to drive sideways; else the odometry tells.
LogCalibration calibrate(ScanMotions& motions, bool omni,
                         const std::function<bool(double fraction)>& keep_going = {});

}  // namespace parloc
