// Writes ROS 2 messages as bytes: plain CDR, little-endian, the counterpart of message_reader.h.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/math/pose.h"
#include "common/model/trajectory.h"
#include "common/ros/messages.h"
#include "common/ros/rigid_transform.h"

namespace parloc {

/// A time as ROS 2 has it.
struct RosTime {
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;

  std::int64_t since_1970_ns() const { return std::int64_t{1'000'000'000} * seconds + nanoseconds; }
};
/// To the nearest nanosecond. Throws Error{input} for what does not fit (before 1901, after 2038, NaN).
RosTime ros_time(double stamp_s);

/// Fields in the order of the message definition.
class MessageWriter {
 public:
  MessageWriter() : bytes_(std::string_view("\0\1\0\0", 4)) {}

  template <class Number>
  void number(Number value) {
    align(sizeof(Number));
    char raw[sizeof(Number)];
    __builtin_memcpy(raw, &value, sizeof(Number));
    if constexpr (std::endian::native == std::endian::big)
      for (std::size_t k = 0; k < sizeof(Number) / 2; ++k) std::swap(raw[k], raw[sizeof(Number) - 1 - k]);
    bytes_.append(raw, sizeof(Number));
  }
  void text(std::string_view text);
  void count(std::size_t count) { number(static_cast<std::uint32_t>(count)); }
  /// A sequence of numbers: count, then values.
  template <class Number>
  void numbers(const std::vector<Number>& values) {
    count(values.size());
    bytes_.reserve(bytes_.size() + 8 + values.size() * sizeof(Number));
    for (const Number value : values) number(value);
  }

  std::string_view bytes() const { return bytes_; }

 private:
  void align(std::size_t size) {
    constexpr std::size_t head = 4;  // from which it is not counted
    bytes_.resize((bytes_.size() - head + size - 1) / size * size + head, '\0');
  }

  std::string bytes_;
};

/// A particle, a share of the weight of all.
struct WeightedPose {
  Pose pose;
  double weight = 0.0;
};

struct DiagnosticMessage {
  enum class Level : std::uint8_t { ok = 0, warn = 1, error = 2, stale = 3 };
  MessageHeader header;
  Level level = Level::ok;
  std::string name, message;
  std::vector<std::pair<std::string, std::string>> values;
};

MessageWriter write_laser_scan(const LaserScanMessage& scan);  ///< sensor_msgs/LaserScan
/// nav_msgs/Odometry, nothing said of how sure it is or how fast.
MessageWriter write_odometry(const OdometryMessage& odometry);
MessageWriter write_transforms(const std::vector<TransformMessage>& transforms);  ///< tf2_msgs/TFMessage
MessageWriter write_occupancy_grid(const OccupancyGridMessage& grid);             ///< nav_msgs/OccupancyGrid
MessageWriter write_pose(const MessageHeader& header, const Pose& pose);  ///< geometry_msgs/PoseStamped
/// geometry_msgs/PoseWithCovarianceStamped; the covariance of x, y and heading row by row [m^2, m rad,
/// rad^2].
MessageWriter write_pose_with_covariance(const MessageHeader& header, const Pose& pose,
                                         const double (&covariance)[9]);
/// nav_msgs/Path; poses have their own stamps.
MessageWriter write_path(const MessageHeader& header, const std::vector<StampedPose>& poses);
/// nav2_msgs/ParticleCloud
MessageWriter write_particles(const MessageHeader& header, const std::vector<WeightedPose>& particles);
/// diagnostic_msgs/DiagnosticArray with one status.
MessageWriter write_diagnostics(const DiagnosticMessage& message);

/// A planar pose in space, upside down (turned about its own x axis by half a turn) or not. planar() of it
/// has the same heading to the bit wherever a quaternion of doubles can say it, else the nearest.
RigidTransform spatial(const Pose& pose, bool upside_down = false);

}  // namespace parloc
