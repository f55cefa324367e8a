// Writes the records of a log as a log in another format.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/io/log.h"
#include "common/mcap/mcap_writer.h"

namespace parloc::tools {

/// A log that is being written. All members throw Error{output} where it cannot be, and Error{input} for what
/// its format cannot hold.
class ConvertedLog {
 public:
  virtual ~ConvertedLog() = default;
  virtual void write(const LogRecord& record) = 0;
  virtual void finish() = 0;
  /// What reading it again will not give back, one line each.
  virtual std::vector<std::string> losses() const = 0;
};

/// ROS 2 messages in MCAP: each LiDAR on the topic of its name, /odom, /tf, /tf_static. Read again it has the
/// same records in the order of their stamps: ranges to the bit, stamps to the nanosecond, headings to the
/// bit of most, angles and limits in single precision.
std::unique_ptr<ConvertedLog> convert_to_mcap(McapWriter::Sink sink);

/// CARMEN text: ODOM and ROBOTLASER1 to 9 lines, LiDARs by the number in their name, else the first one free.
/// Numbers have all of their digits: read again they are the same, but for a LiDAR's place on the robot,
/// which is the difference of two poses (1e-15).
std::unique_ptr<ConvertedLog> convert_to_carmen(McapWriter::Sink sink);

}  // namespace parloc::tools
