// What is in a log: its scans by LiDAR, its odometry, what a reader worked around.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/model/scan_config.h"
#include "tools/log/stamp_survey.h"

namespace parloc::tools {

/// The scans of one LiDAR. Angles and limits are those of the first scan.
struct ScanSurvey {
  StampSurvey stamps;
  std::map<std::size_t, std::size_t> scans_of_beams;  ///< How many scans have so many beams.
  double first_bearing_rad = 0.0, last_bearing_rad = 0.0, angle_step_rad = 0.0;
  bool uneven = false;
  double range_min_m = 0.0, range_max_m = 0.0,
         scan_time_s = 0.0;  ///< As the log states them; 0: it does not.
  Pose T_base_sensor;
  bool upside_down = false, mount_moves = false;
  /// Readings by what they are. `far` is at or beyond the stated maximum.
  std::size_t zero = 0, infinite = 0, not_a_number = 0, negative = 0, far = 0, good = 0;
  double nearest_m = 0.0, farthest_m = 0.0;  ///< Of the good ones.

  std::size_t readings() const { return zero + infinite + not_a_number + negative + far + good; }
};

/// Odometry, whether it came alone or with a scan.
struct OdometrySurvey {
  StampSurvey stamps;
  std::size_t alone = 0;  ///< Without a scan.
  double length_m = 0.0, turned_rad = 0.0;
  double max_speed_mps = 0.0, max_turn_rate_rad_s = 0.0;  ///< Over half a second or more.
  /// While the robot stands (over half a second slower than 1 cm/s and 0.01 rad/s): how long in all, and how
  /// far one reading is from the next (root mean square).
  double standing_s = 0.0, standing_noise_m = 0.0, standing_noise_rad = 0.0;
};

struct LogSurvey {
  std::map<std::string, ScanSurvey> lidars;  ///< By Scan::sensor.
  OdometrySurvey odometry;
  LogWarnings warnings;
  std::vector<LogNote> mounts;  ///< Where the scans contradict the place that is stated for their LiDAR.
  bool interrupted = false;
};

/// `lidars`: what the settings say of them. Reads the log to its end, or until `stop` says so; tells
/// `progress` the share that was read. Throws as LogReader::next().
LogSurvey survey_log(LogReader& log, const std::vector<LidarConfig>& lidars,
                     const std::function<void(double)>& progress, const std::function<bool()>& stop);

}  // namespace parloc::tools
