// One scan of a LiDAR, as it was recorded.
#pragma once

#include <string>
#include <vector>

#include "common/math/pose.h"

namespace parloc {

/// One LiDAR scan. Beam i looks at angle_min_rad + i * angle_step_rad in the sensor frame, or at
/// bearings_rad[i] where there are any.
struct Scan {
  double stamp_s = 0.0;  ///< When it was taken: its first beam, unless StampAt says otherwise.
  std::string sensor{};  ///< Which LiDAR: "front", "rear", "robotlaser1"; may be empty where there is one.
  Pose T_base_sensor{};  ///< Where the LiDAR sits on the robot.
  bool upside_down = false;       ///< As the log says: mirrored about its own x axis, angles run clockwise.
  double angle_min_rad = 0.0;     ///< Where the first beam looks.
  double angle_step_rad = 0.0;    ///< From beam to beam; below 0 clockwise.
  double range_min_m = 0.0;       ///< 0: the log does not say.
  double range_max_m = 0.0;       ///< 0: the log does not say.
  double scan_time_s = 0.0;       ///< From the first beam to the last; 0: the log does not say.
  std::vector<float> ranges_m{};  ///< As recorded: may hold NaN, inf, zeros, values beyond the maximum.
  /// Of uneven beams, one per range, unwrapped, in ascending or descending order; empty: even.
  std::vector<double> bearings_rad{};
  /// When each beam was taken, relative to the stamp, one per range; empty: evenly over the scan's time.
  std::vector<double> beam_times_s{};
};

/// Where a beam of a scan ended: base frame at the scan's stamp.
struct EndPoint {
  float x_m;  ///< Ahead.
  float y_m;  ///< To the left.
};

}  // namespace parloc
