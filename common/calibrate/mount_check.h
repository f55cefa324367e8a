// Whether the scans of a log contradict where it says that their LiDAR sits.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/io/log.h"
#include "common/model/scan_config.h"

namespace parloc {

class ScanMotions;

/// Takes a log's records as they come, until it has enough, and then compares how scans and odometry moved.
/// Where that does not tell, it says nothing. Deterministic on every machine.
class MountCheck {
 public:
  /// So many motions of each LiDAR, or scans of all, are enough.
  static constexpr std::size_t kEnoughMotions = 100, kMostScans = 5000;
  /// Less is not worth a line, nor what is within four standard deviations.
  static constexpr double kLeastTurn_rad = 0.09, kLeastWay_m = 0.1;

  explicit MountCheck(std::vector<LidarConfig> lidars = {}, const ScanConfig& scan = {});
  ~MountCheck();

  void add(const LogRecord& record);
  bool enough() const;
  /// A line for each LiDAR that sits elsewhere, is turned or upside down against what is stated: "... as if
  /// turned by 178 +- 1 degrees". Once.
  std::vector<LogNote> verdict();

 private:
  std::vector<LidarConfig> lidars_;
  ScanConfig scan_;
  std::unique_ptr<ScanMotions> motions_;
};

}  // namespace parloc
