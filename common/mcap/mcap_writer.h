// Writes MCAP files (mcap.dev, version 0) of ROS 2 messages, as they come.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace parloc {

/// What a topic's messages are.
struct McapTopic {
  std::string name;        ///< "/scan"
  std::string type;        ///< "sensor_msgs/msg/LaserScan"
  std::string definition;  ///< ros2msg, with the definitions of the types in it (message_definition()).
  /// Who subscribes later still gets the last message: its quality of service is transient-local.
  bool latched = false;
};

/// Profile "ros2", messages in CDR; zstd chunks of about 1 MiB with checksums and message indexes, then a
/// summary. A chunk that is finished is given out at once, and whatever was given out is readable even if
/// nothing follows. The same calls give the same bytes where no time ends a chunk.
class McapWriter {
 public:
  /// Takes bytes that follow those before; throws Error{output}.
  using Sink = std::function<void(std::string_view bytes)>;

  /// Gives nothing out yet. A chunk ends at the first message that comes `longest_chunk_s` of wall time after
  /// its first. Throws Error{output} in a build without zstd.
  explicit McapWriter(Sink sink, double longest_chunk_s = 1e9);
  /// Without finish(), what is not given out is lost.
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// The number that write() knows it by. At most 65535.
  std::uint16_t add_topic(const McapTopic& topic);
  /// `stamp_ns`: when it was recorded, since 1970; before that counts as 1970.
  void write(std::uint16_t topic, std::int64_t stamp_ns, std::string_view message);
  /// Ends the last chunk and writes the summary. Nothing may follow.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
