// Tells the notes of a log on standard error, as soon as its reader has made them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/model/scan_config.h"

namespace parloc::tools {

class NoteTeller {
 public:
  /// `lidars` outlives this. `quiet`: tells nothing.
  NoteTeller(std::string log_name, const std::vector<LidarConfig>& lidars, bool quiet = false);

  /// Those that have come since the last call, "parloc: LOG: note" each, without those that settings settle.
  void tell(const LogWarnings& warnings);

 private:
  std::string log_name_;
  const std::vector<LidarConfig>& lidars_;
  bool quiet_;
  std::size_t seen_ = 0;
};

}  // namespace parloc::tools
