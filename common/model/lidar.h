// One LiDAR as the filter sees it: what the log says of a scan, and what the configuration says over it.
#pragma once

#include <cstddef>
#include <vector>

#include "common/math/pose.h"
#include "common/model/scan.h"
#include "common/model/scan_config.h"

namespace parloc {

/// Everything about a scan but its ranges, decided.
struct LidarSetup {
  Pose T_base_sensor;
  bool upside_down = false;
  bool own_bearings = false;  ///< The scan has an angle for each beam, and they count; else the next two do.
  double angle_min_rad = 0.0;
  double angle_step_rad = 0.0;
  const std::vector<AngleInterval>* mask = nullptr;  ///< Of the LidarConfig; null if there is none.
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  int max_beams = 0;
  ZeroPolicy zero_policy = ZeroPolicy::invalid;
  double scan_time_s = 0.0;  ///< From the first beam to the last.
  StampAt stamp_at = StampAt::first;
  bool own_times = false;  ///< The scan has a time for each beam, and they count.
};

/// The entry of that name; null if there is none.
const LidarConfig* find_lidar(const std::vector<LidarConfig>& lidars, const std::string& name);

/// Lives no longer than `lidar`. `lidar`, if any, first; then the scan itself; then `config`. Throws
/// Error{input} for a scan whose stamp, mount, angles, range limits or time are not finite where they count,
/// or whose bearings or times are not one per range, not finite, or (bearings) not in order.
LidarSetup lidar_setup(const Scan& scan, const ScanConfig& config, const LidarConfig* lidar = nullptr);

/// When beam i was taken, relative to the scan's stamp.
double beam_time_s(const Scan& scan, const LidarSetup& setup, std::size_t i);

/// Whether the beams were taken at different times.
bool takes_time(const Scan& scan, const LidarSetup& setup);

/// The latest beam's time relative to the stamp, at least 0: how far ahead odometry matters.
double latest_beam_s(const Scan& scan, const LidarSetup& setup);

/// In the sensor frame as it is mounted: upside down, angles run the other way.
double beam_bearing_rad(const Scan& scan, const LidarSetup& setup, std::size_t i);

/// Whether beam i looks into the mask: then it is as if it had not been measured.
bool is_masked(const Scan& scan, const LidarSetup& setup, std::size_t i);

}  // namespace parloc
