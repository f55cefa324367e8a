// A recording of messages on topics, whatever its container: what readers of bags give out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace parloc {

struct BagTopic {
  std::string name;      ///< "/scan"
  std::string type;      ///< "sensor_msgs/LaserScan", for ROS 1 and 2 alike.
  std::string encoding;  ///< "cdr" (ROS 2), "ros1", or whatever else the file says.
};

/// A message is refused beyond this size [bytes]: maps are large, of the rest none that is of use here.
inline std::size_t longest_message(const BagTopic& topic) {
  return topic.type == "nav_msgs/OccupancyGrid" ? std::size_t{64} << 20 : std::size_t{16} << 20;
}

/// One message as it was recorded. The bytes stay until the next call of next().
struct BagMessage {
  std::size_t topic = 0;      ///< Index into topics().
  std::int64_t stamp_ns = 0;  ///< When it was recorded.
  std::string_view bytes;
};

/// What a reader worked around. Nothing is left out without being counted here.
struct BagFaults {
  std::size_t count = 0;
  std::vector<std::string> messages;  ///< "file: what", at most 20.
};

/// The messages of a bag, in the order of their recording, however they lie in the file. Memory does not grow
/// with the bag: some chunks, and a few bytes per chunk.
class BagReader {
 public:
  virtual ~BagReader() = default;
  /// All of the bag, known from the start.
  virtual const std::vector<BagTopic>& topics() const = 0;
  /// Whether the topic has no message; false as well where only reading all of the bag would tell.
  virtual bool is_empty(std::size_t topic) const = 0;
  /// When the first message was recorded [ns]; the largest number for a bag without any.
  virtual std::int64_t first_stamp_ns() const = 0;
  /// Starts again from the beginning, with those topics alone: one flag per topic. Others are not unpacked
  /// where the container allows it.
  virtual void select(const std::vector<bool>& topics) = 0;
  /// The next message of the topics selected; false at the end. Never throws for damaged data: what is
  /// whole is given out, the rest counted.
  virtual bool next(BagMessage& message) = 0;
  virtual const BagFaults& faults() const = 0;
  /// Share of the bag that was read, 0 to 1.
  virtual double progress() const = 0;
  /// "mcap", "ros1" or "sqlite3": for people.
  virtual std::string container() const = 0;
};

}  // namespace parloc
