// The scans of a log, each with the odometry that must be known to use it.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "common/error.h"
#include "common/filter/config.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"

namespace parloc::tools {

/// Scans in file order. Reads ahead of a scan as far as its last beam's time, so that the odometry there is
/// known.
class ScanStream {
 public:
  /// `check` is called after each record with its line, and with 0 at the end of the log; it may throw.
  ScanStream(LogReader& log, const FilterConfig& config, std::function<void(std::size_t line)> check)
      : log_(log), config_(config), check_(std::move(check)) {}

  /// False at the end of the log.
  bool next(LogRecord& scan);

  /// take(StampedPose) for the odometry that was read since the last call.
  template <class Take>
  void pass_odometry(const Take& take) {
    for (const StampedPose& reading : odometry_) take(reading);
    odometry_.clear();
  }

 private:
  bool read_record();

  LogReader& log_;
  const FilterConfig& config_;
  std::function<void(std::size_t)> check_;
  std::deque<LogRecord> waiting_;
  Trajectory odometry_;
  double newest_s_ = -std::numeric_limits<double>::infinity();
};

/// For a log without any.
Error no_scan(const std::string& log_name, const LogWarnings& warnings);

}  // namespace parloc::tools
