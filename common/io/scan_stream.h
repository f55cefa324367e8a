// The scans of a log, each with the odometry that must be known to use it.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/model/scan_config.h"

namespace parloc {

/// Scans in file order. Reads ahead of a scan as far as its last beam's time, so that the odometry there is
/// known.
class ScanStream {
 public:
  /// `scan` and `lidars` outlive this. `check` is called after each record with its line, and with 0 at the
  /// end of the log; it may throw.
  ScanStream(LogReader& log, const ScanConfig& scan, const std::vector<LidarConfig>& lidars,
             std::function<void(std::size_t line)> check)
      : log_(log), scan_(scan), lidars_(lidars), check_(std::move(check)) {}

  /// Throws Error{input} for a scan whose arrays do not fit together, which is left out if it is called
  /// again. False at the end of the log, and where one that waits has no more for now.
  bool next(LogRecord& scan);

  /// take(StampedPose) for the odometry that was read since the last call.
  template <class Take>
  void pass_odometry(const Take& take) {
    for (const StampedPose& reading : odometry_) take(reading);
    odometry_.clear();
  }

 private:
  bool read_record();
  bool read_up_to_last_beam();
  double latest_beam_s();

  LogReader& log_;
  const ScanConfig& scan_;
  const std::vector<LidarConfig>& lidars_;
  std::function<void(std::size_t)> check_;
  std::deque<LogRecord> waiting_;
  Trajectory odometry_;
  int looked_ = 0;  ///< Records, for what the first scan that waits still needs.
  double newest_s_ = -std::numeric_limits<double>::infinity();
};

/// For a log without any: with what it has instead.
Error no_scan(const std::string& log_name, const LogWarnings& warnings);

}  // namespace parloc
