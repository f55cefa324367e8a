// The ROS messages that parloc has a use for. Each decoder throws BrokenMessage.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/ros/message_reader.h"
#include "common/ros/rigid_transform.h"

namespace parloc {

/// A time of ROS in seconds: the double nearest to it, as text of the same decimals is read.
inline double seconds_of(std::int64_t seconds, std::uint32_t nanoseconds) {
  const std::int64_t whole_ns = seconds * 1'000'000'000 + nanoseconds;
  constexpr std::int64_t exact = std::int64_t{1} << 53;
  return whole_ns > -exact && whole_ns < exact
             ? static_cast<double>(whole_ns) / 1e9
             : static_cast<double>(seconds) + static_cast<double>(nanoseconds) / 1e9;
}

struct MessageHeader {
  double stamp_s = 0.0;
  std::string frame;  ///< Without the slash that ROS 1 put before it.
};

/// sensor_msgs/LaserScan, or the first echoes of sensor_msgs/MultiEchoLaserScan.
struct LaserScanMessage {
  MessageHeader header;
  float angle_min_rad = 0.0f, angle_max_rad = 0.0f, angle_step_rad = 0.0f;
  float time_step_s = 0.0f;  ///< From beam to beam.
  float scan_time_s = 0.0f;  ///< From scan to scan.
  float range_min_m = 0.0f, range_max_m = 0.0f;
  std::vector<float> ranges_m;
};
void read_laser_scan(MessageReader in, LaserScanMessage& scan);
void read_multi_echo_scan(MessageReader in, LaserScanMessage& scan);

struct OdometryMessage {
  MessageHeader header;
  std::string child_frame;
  RigidTransform pose;
};
OdometryMessage read_odometry(MessageReader in);

struct TransformMessage {
  MessageHeader header;  ///< Its frame is the parent.
  std::string child_frame;
  RigidTransform T_parent_child;
};
/// geometry_msgs/TransformStamped.
TransformMessage read_transform(MessageReader in);
/// tf2_msgs/TFMessage and tf/tfMessage; with quaternions as they were written.
std::vector<TransformMessage> read_transforms(MessageReader in);

/// geometry_msgs/PoseStamped, or PoseWithCovarianceStamped, whose pose stands at the same place.
struct PoseMessage {
  MessageHeader header;
  RigidTransform pose;
};
PoseMessage read_pose_stamped(MessageReader in);

/// nav_msgs/OccupancyGrid.
struct OccupancyGridMessage {
  MessageHeader header;
  float resolution_m = 0.0f;
  std::uint32_t width = 0, height = 0;
  RigidTransform origin;
  std::vector<std::int8_t> cells;  ///< Row by row from the origin: -1 unknown, 0 free to 100 occupied.
};
OccupancyGridMessage read_occupancy_grid(MessageReader in);

/// A number of each point of a sensor_msgs/PointCloud2.
struct CloudField {
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t type = 0;  ///< 1 to 8: int8, uint8, int16, uint16, int32, uint32, float32, float64.
};
struct PointCloudMessage {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;
  std::vector<CloudField> fields;
  bool big_endian = false;
  std::uint32_t point_bytes = 0, row_bytes = 0;
  std::string_view data;  ///< Of the message's own bytes.
};
PointCloudMessage read_point_cloud(MessageReader in);

}  // namespace parloc
