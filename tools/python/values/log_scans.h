// Logs as Python has them: to be read from their beginning as often as one likes.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "common/config/config.h"
#include "common/io/log.h"
#include "common/io/scan_stream.h"
#include "common/model/trajectory.h"

namespace parloc::python {

/// One scan, and the odometry that was read since the scan before, up to where its last beam was taken.
struct ScanRecord {
  LogRecord record;
  Trajectory readings;

  /// What every filter does with it.
  template <class Filter>
  auto step(Filter& filter) const {
    for (const StampedPose& reading : readings) filter.add_odometry(reading.stamp_s, reading.pose);
    return filter.step(record.odometry, record.scan);
  }
};

struct Log {
  std::string name;
  Config config;  ///< What of it is read, and what its LiDARs are like, unless a reader says otherwise.
  std::function<std::unique_ptr<LogReader>(const Config& config)> open;
};

/// Going through a log once.
class Scans {
 public:
  Scans(const Log& log, Config config)
      : name_(log.name),
        config_(std::move(config)),
        reader_(log.open(config_)),
        stream_(*reader_, config_.scan, config_.lidars, [](std::size_t) {}) {}

  /// False at the end. Throws Error{input} for a log without a scan.
  bool next(ScanRecord& scan) {
    if (!stream_.next(scan.record)) {
      if (read_ == 0) throw no_scan(name_, reader_->warnings());
      return false;
    }
    ++read_;
    scan.readings.clear();
    stream_.pass_odometry([&](const StampedPose& reading) { scan.readings.push_back(reading); });
    return true;
  }
  const LogReader& reader() const { return *reader_; }

 private:
  std::string name_;
  Config config_;
  std::unique_ptr<LogReader> reader_;
  ScanStream stream_;
  std::size_t read_ = 0;
};

}  // namespace parloc::python
