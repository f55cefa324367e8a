// The CARMEN reader on any bytes: every record is finite where it must be, and what is written is read back.
#include <cmath>

#include "common/io/log.h"
#include "tests/fuzz/one_line.h"

namespace {

using parloc::fuzz::require;

bool finite(const parloc::Pose& pose) {
  return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::fabs(pose.theta_rad) < 3.2;
}

void check(const parloc::LogRecord& record, std::size_t input_size) {
  require(std::isfinite(record.stamp_s) && finite(record.odometry));
  if (record.kind != parloc::RecordKind::scan) return;
  require(finite(record.scan.T_base_sensor));
  require(!record.scan.ranges_m.empty() && record.scan.ranges_m.size() <= input_size);
  const double last = record.scan.angle_min_rad +
                      record.scan.angle_step_rad * static_cast<double>(record.scan.ranges_m.size() - 1);
  require(std::fabs(record.scan.angle_min_rad) < 13.0 && std::fabs(last) < 26.0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto reader = parloc::carmen_log_from_text(parloc::fuzz::text_of(data, size), "fuzz");
    parloc::LogRecord record;
    std::size_t records = 0;
    while (reader->next(record)) {
      check(record, size);
      ++records;
      if (record.kind != parloc::RecordKind::scan || records > 4) continue;
      parloc::LogRecord back;
      const auto again = parloc::carmen_log_from_text(parloc::carmen_line(record) + "\n", "again");
      if (again->next(back)) require(back.scan.ranges_m.size() == record.scan.ranges_m.size());
    }
    require(reader->warnings().messages.size() <= 20);
  } catch (const parloc::Error&) {
  }
  return 0;
}
