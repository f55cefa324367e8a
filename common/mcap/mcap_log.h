// Writes what a robot recorded, and what is made of it, as ROS 2 messages in an MCAP file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/mcap/mcap_writer.h"
#include "common/model/scan.h"
#include "common/ros/message_writer.h"

namespace parloc {

/// Frames: the robot is "base_link", its odometry's origin "odom", a LiDAR "laser" with its name behind.
/// Messages are recorded at their stamps; one that is earlier than one before it at that one's, so that the
/// order stays. All members throw Error{output} where the file cannot be written, and Error{input} for stamps
/// that ROS cannot hold.
class McapLog {
 public:
  static constexpr const char* kBase = "base_link";
  static constexpr const char* kOdometry = "odom";

  /// As McapWriter.
  explicit McapLog(McapWriter::Sink sink, double longest_chunk_s = 1e9);

  /// The topic is there from its first message on. `type`: "sensor_msgs/msg/LaserScan".
  void write(const std::string& topic, const char* type, double stamp_s, const MessageWriter& message,
             bool latched = false);
  /// On /tf.
  void write_transforms(double stamp_s, const std::vector<TransformMessage>& transforms);
  /// /odom, and on /tf the same from "odom" to "base_link".
  void write_odometry(double stamp_s, const Pose& odometry);
  /// A sensor_msgs/LaserScan, after its LiDAR's place on the robot if that is not known: on /tf_static, from
  /// the first time on that it has moved (by more than 1e-5 m or rad) on /tf for each scan. Angles that run
  /// clockwise make a LiDAR upside down. Throws Error{input} for a scan whose beams are not even in angle and
  /// time.
  void write_scan(const std::string& topic, const Scan& scan);
  void finish() { writer_.finish(); }

  std::size_t messages() const { return messages_; }
  /// LiDARs that did not stay where they were, by name.
  std::vector<std::string> moving() const;

 private:
  struct Mount {
    Pose first;
    bool upside_down = false, moves = false;
    TransformMessage transform;
  };
  void write_mount(const std::string& sensor, double stamp_s, const Pose& T_base_sensor, bool upside_down);

  McapWriter writer_;
  std::map<std::string, std::uint16_t> topics_;
  std::map<std::string, Mount> mounts_;  ///< By LiDAR.
  std::int64_t latest_ns_ = 0;
  std::size_t messages_ = 0;
};

/// Its message in the frame of its LiDAR as it is mounted, angles counter-clockwise; float32 throughout.
/// Throws Error{input} for beams that are not even in angle and time.
LaserScanMessage laser_scan_message(const Scan& scan);
/// "laser_front" for "front".
std::string laser_frame(const std::string& sensor);

}  // namespace parloc
