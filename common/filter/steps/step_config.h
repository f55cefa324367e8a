// What every filter reads that takes scans with odometry, whatever it makes of them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/filter/steps/compute_config.h"
#include "common/model/motion_config.h"
#include "common/model/scan_config.h"

namespace parloc {

/// What the steps of every filter read.
struct StepConfig : ComputeConfig {
  std::uint64_t seed = 1;  ///< Of all random numbers: same seed, same answer.
  /// Take a scan after this much translation [m]. 0 is no reason to take a scan; this and update_min_a 0:
  /// every scan.
  double update_min_d = 0.0;
  double update_min_a = 0.0;        ///< Or after this much rotation [rad].
  MotionConfig motion;              ///< How the robot moves, and how far odometry is to be believed.
  ScanConfig scan;                  ///< Which beams are used.
  std::vector<LidarConfig> lidars;  ///< May be empty; in no order.
  /// No setting: told in one line what a user should know of the input that goes on all the same, each kind
  /// once per start (a LiDAR that `lidars` does not list while a name near it has no scan, odometry that is
  /// not finite, that jumps). Called within a step, by its thread. Empty: nobody is told.
  std::function<void(const std::string& warning)> on_warning;
};

}  // namespace parloc
