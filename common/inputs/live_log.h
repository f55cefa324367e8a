// The log of a robot that drives, while it is made.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/inputs/robot_messages.h"
#include "common/io/log.h"

namespace parloc {

/// Messages go in as they come, records come out as soon as they are known: a scan when the odometry has
/// passed its stamp. What cannot be used is left out and counted; nothing throws.
class LiveLog final : public LogReader {
 public:
  LiveLog(const std::string& name, const LogChoice& choice, bool odometry_topic)
      : messages_({name, odometry_topic, true, true}, choice) {}

  /// As RobotMessages, in CDR.
  void take(TopicRole role, const std::string& topic, std::string_view bytes) {
    messages_.take(role, topic, "cdr", bytes);
  }
  void forget() { messages_.forget(); }
  std::size_t troubles() const { return messages_.troubles(); }
  std::vector<std::string> take_news() { return messages_.take_news(); }
  /// Scans that wait for a transform or the odometry.
  std::size_t waiting() const { return messages_.waiting(); }

  bool next(LogRecord& record) override { return messages_.next(record); }
  bool waits() const override { return true; }
  const LogWarnings& warnings() const override { return warnings_ = messages_.warnings(); }
  double progress() const override { return 0.0; }

 private:
  RobotMessages messages_;
  mutable LogWarnings warnings_;
};

}  // namespace parloc
