// What every filter reads that takes scans with odometry, whatever it makes of them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/filter/compute_config.h"
#include "common/model/motion_config.h"
#include "common/model/scan_config.h"

namespace parloc {

struct StepConfig : ComputeConfig {
  std::uint64_t seed = 1;
  double update_min_d = 0.0;  ///< Take a scan after this much translation [m].
  double update_min_a = 0.0;  ///< Or after this much rotation [rad]; both 0: every scan.
  MotionConfig motion;
  ScanConfig scan;
  std::vector<LidarConfig> lidars;  ///< May be empty; in no order.
};

}  // namespace parloc
