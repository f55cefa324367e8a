// What every reader of bags must hold on any bytes: they end, with messages of topics that there are, and a
// log of finite records or one line that says why not.
#pragma once

#include <cmath>
#include <string>

#include "common/bag/open_bag.h"
#include "common/bag/temporary_file.h"
#include "common/io/bag_log.h"
#include "tests/fuzz/one_line.h"

namespace parloc::fuzz {

inline bool finite(const Pose& pose) {
  return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.theta_rad);
}

inline void check_record(const LogRecord& record) {
  require(std::isfinite(record.stamp_s) && finite(record.odometry) && finite(record.scan.T_base_sensor));
  if (record.kind == RecordKind::scan) require(!record.scan.ranges_m.empty());
}

inline void read_bag(const std::uint8_t* data, std::size_t size) {
  const TemporaryFile file;
  file.write(text_of(data, size));
  if (!is_bag(file.path())) return;
  constexpr std::size_t most = 20000;  // a few packed bytes may be very many messages
  reads_or_says_why(ErrorKind::input, [&] {
    const auto bag = open_bag(file.path());
    BagMessage message;
    for (std::size_t k = 0; k < most && bag->next(message); ++k)
      require(message.topic < bag->topics().size());
    for (std::size_t k = 0; k < bag->topics().size(); ++k) (void)bag->is_empty(k);
    require(bag->faults().messages.size() <= 40);
  });
  for (const bool without_odometry : {false, true}) {
    reads_or_says_why(ErrorKind::input, [&] {
      LogChoice choice;
      choice.without_odometry = without_odometry;
      const auto log = open_bag_log(file.path(), choice);
      LogRecord record;
      for (std::size_t k = 0; k < most && log->next(record); ++k) check_record(record);
      (void)log->warnings();
    });
  }
}

}  // namespace parloc::fuzz
