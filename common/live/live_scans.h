// What is live of every filter: messages in, scans out, and what went wrong told once.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/inputs/live_log.h"
#include "common/io/scan_stream.h"

namespace parloc {

/// The scans of a robot that drives, each with the odometry that it needs. `scan` and `lidars` outlive this.
class LiveScans {
 public:
  LiveScans(const LogChoice& choice, bool odometry_topic, const ScanConfig& scan,
            const std::vector<LidarConfig>& lidars)
      : log_("robot", choice, odometry_topic), scan_(scan), lidars_(lidars) {
    begin();
  }

  void take(TopicRole role, const std::string& topic, std::string_view bytes) {
    log_.take(role, topic, bytes);
  }
  /// False: more has to be taken first. A scan that cannot be used is told and left out.
  bool next(LogRecord& scan);
  /// take(StampedPose) for the odometry that was read since the last call.
  template <class Take>
  void pass_odometry(const Take& take) {
    stream_->pass_odometry(take);
  }
  void forget() {
    log_.forget();
    begin();
  }
  std::size_t waiting() const { return log_.waiting(); }

  /// Once, whatever numbers are in it: of a hundred bad messages the first is told.
  void tell(const std::string& line);
  /// What was told since the last call.
  std::vector<std::string> troubles();

 private:
  void begin() {
    stream_.emplace(log_, scan_, lidars_, [](std::size_t) {});
  }

  LiveLog log_;
  const ScanConfig& scan_;
  const std::vector<LidarConfig>& lidars_;
  std::optional<ScanStream> stream_;
  std::size_t looked_at_ = 0;    ///< Troubles of the log.
  std::set<std::string> known_;  ///< Lines that were told, without their numbers.
  std::vector<std::string> told_;
};

}  // namespace parloc
