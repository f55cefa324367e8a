// parloc learn --what mount,odometry,delay: a calibration from a log, without a map.
#pragma once

#include <string>

#include "common/config/config.h"

namespace parloc::tools {

struct CalibrateOptions {
  std::string log, what, out;
  bool quiet = false, json = false;
};

/// The program's part of it; the exit code.
int calibrate_log(const CalibrateOptions& options, const Config& config, const std::string& typed);

}  // namespace parloc::tools
