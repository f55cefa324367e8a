// What is odd about a log: odometry that is of no use.
#pragma once

#include <string>

#include "common/config/config.h"
#include "common/io/log.h"

namespace parloc::tools::slam {

constexpr const char* kOdometryFromScans = "the log has no odometry that moves: taken from its scans";

/// Whether a log of two scans or more has the same odometry throughout. Reads only until two readings differ.
bool odometry_stands_still(LogReader& log);
/// Has the odometry taken from the scans where the recorded one, that was to be used, never moves; whether it
/// did so. A log that is not a plain file, and can be read only once, is not looked at.
bool choose_odometry(const std::string& log_path, Config& config);

}  // namespace parloc::tools::slam
