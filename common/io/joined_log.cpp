#include "common/io/joined_log.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"
#include "common/io/odometry_joiner.h"

namespace parloc {

namespace {

class JoinedLog final : public LogReader {
 public:
  JoinedLog(std::unique_ptr<LogReader> log, std::string name)
      : log_(std::move(log)), name_(std::move(name)) {}

  bool next(LogRecord& record) override {
    while (!joiner_.next(record)) {
      if (ended_) {
        if (scans_in_ > 0 && scans_out_ == 0)
          throw input_error(
              name_, 0,
              fmt::format("{} scans say no odometry (RAWLASER): {}", scans_in_, joiner_.why_none()));
        return false;
      }
      read();
    }
    if (record.kind == RecordKind::scan) ++scans_out_;
    return true;
  }

  const LogWarnings& warnings() const override {
    warnings_ = log_->warnings();
    for (const std::string& line : joiner_.left_out(name_)) warnings_.messages.push_back(line);
    return warnings_;
  }

  double progress() const override { return log_->progress(); }

 private:
  void read() {
    LogRecord record;
    ended_ = !log_->next(record);
    if (ended_) return joiner_.finish();
    if (record.kind == RecordKind::odometry)
      return joiner_.add_odometry(record.stamp_s, record.odometry, record.line);
    ++scans_in_;
    joiner_.add_scan(std::move(record));
  }

  std::unique_ptr<LogReader> log_;
  std::string name_;
  OdometryJoiner joiner_;
  bool ended_ = false;
  std::size_t scans_in_ = 0, scans_out_ = 0;
  mutable LogWarnings warnings_;
};

}  // namespace

std::unique_ptr<LogReader> join_odometry(std::unique_ptr<LogReader> log, std::string name) {
  return std::make_unique<JoinedLog>(std::move(log), std::move(name));
}

}  // namespace parloc
