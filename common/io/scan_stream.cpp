#include "common/io/scan_stream.h"

#include <fmt/format.h>

#include <utility>

#include "common/model/lidar.h"

namespace parloc {

bool ScanStream::next(LogRecord& scan) {
  while (waiting_.empty())
    if (!read_record()) return false;
  if (!read_up_to_last_beam()) return false;
  looked_ = 0;
  scan = std::move(waiting_.front());
  waiting_.pop_front();
  return true;
}

// Of the scan that waits first; false: more may come.
bool ScanStream::read_up_to_last_beam() {
  const double stamp_s = waiting_.front().stamp_s, until_s = stamp_s + latest_beam_s();
  // Stamps may run backwards: not for ever.
  constexpr int farthest = 1000;
  for (; looked_ < farthest && until_s > stamp_s && newest_s_ < until_s; ++looked_)
    if (!read_record()) return !log_.waits();
  return true;
}

double ScanStream::latest_beam_s() {
  try {
    const Scan& scan = waiting_.front().scan;
    return parloc::latest_beam_s(scan, lidar_setup(scan, scan_, find_lidar(lidars_, scan.sensor)));
  } catch (const Error&) {
    waiting_.pop_front();  // whoever goes on shall not find it again
    throw;
  }
}

bool ScanStream::read_record() {
  LogRecord record;
  const bool there = log_.next(record);
  check_(there ? record.line : 0);
  if (!there) return false;
  newest_s_ = record.stamp_s;
  odometry_.push_back({record.stamp_s, record.odometry});
  if (record.kind == RecordKind::scan) waiting_.push_back(std::move(record));
  return true;
}

Error no_scan(const std::string& log_name, const LogWarnings& warnings) {
  std::string message = "expected at least one scan (FLASER, RLASER or ROBOTLASER1), found none";
  for (const auto& [name, count] : warnings.unread)
    message += fmt::format("{}{} {}", &name == &warnings.unread.front().first ? "; " : ", ", count, name);
  if (!warnings.unread.empty()) message += " lines: not read";
  if (!warnings.messages.empty()) message += fmt::format("; {}", warnings.messages.front());
  return input_error(log_name, 0, message);
}

}  // namespace parloc
