#include "common/ros/messages.h"

#include <limits>

namespace parloc {

namespace {

std::string frame_name(std::string name) {
  if (!name.empty() && name.front() == '/') name.erase(0, 1);
  return name;
}

// ROS 1 counts its headers before the stamp.
MessageHeader read_header(MessageReader& in) {
  if (in.ros1()) in.number<std::uint32_t>();
  const std::int64_t seconds = in.ros1() ? in.number<std::uint32_t>() : in.number<std::int32_t>();
  MessageHeader header;
  header.stamp_s = seconds_of(seconds, in.number<std::uint32_t>());
  header.frame = frame_name(in.text());
  return header;
}

// Point or Vector3, then Quaternion.
RigidTransform read_pose(MessageReader& in) {
  RigidTransform pose;
  for (double* value : {&pose.x_m, &pose.y_m, &pose.z_m, &pose.qx, &pose.qy, &pose.qz, &pose.qw})
    *value = in.number<double>();
  return pose;
}

void read_scan_head(MessageReader& in, LaserScanMessage& scan) {
  scan.header = read_header(in);
  for (float* value : {&scan.angle_min_rad, &scan.angle_max_rad, &scan.angle_step_rad, &scan.time_step_s,
                       &scan.scan_time_s, &scan.range_min_m, &scan.range_max_m})
    *value = in.number<float>();
}

}  // namespace

// What follows the ranges are the intensities: they are not even looked at.
void read_laser_scan(MessageReader in, LaserScanMessage& scan) {
  read_scan_head(in, scan);
  in.numbers(scan.ranges_m);
}

void read_multi_echo_scan(MessageReader in, LaserScanMessage& scan) {
  read_scan_head(in, scan);
  const std::size_t beams = in.count(4);
  scan.ranges_m.clear();
  std::vector<float> echoes;
  for (std::size_t k = 0; k < beams; ++k) {
    in.numbers(echoes);
    scan.ranges_m.push_back(echoes.empty() ? std::numeric_limits<float>::infinity() : echoes.front());
  }
}

OdometryMessage read_odometry(MessageReader in) {
  OdometryMessage odometry;
  odometry.header = read_header(in);
  odometry.child_frame = frame_name(in.text());
  odometry.pose = read_pose(in);
  return odometry;
}

namespace {
void read_next_transform(MessageReader& in, TransformMessage& transform) {
  transform.header = read_header(in);
  transform.child_frame = frame_name(in.text());
  transform.T_parent_child = read_pose(in);
}
}  // namespace

TransformMessage read_transform(MessageReader in) {
  TransformMessage transform;
  read_next_transform(in, transform);
  return transform;
}

std::vector<TransformMessage> read_transforms(MessageReader in) {
  std::vector<TransformMessage> transforms(in.count(64));
  for (TransformMessage& transform : transforms) read_next_transform(in, transform);
  return transforms;
}

PoseMessage read_pose_stamped(MessageReader in) {
  PoseMessage message;
  message.header = read_header(in);
  message.pose = read_pose(in);
  return message;
}

OccupancyGridMessage read_occupancy_grid(MessageReader in) {
  OccupancyGridMessage grid;
  grid.header = read_header(in);
  if (in.ros1()) {
    in.number<std::uint64_t>();  // when the map was loaded
  } else {
    in.number<std::int32_t>();
    in.number<std::uint32_t>();
  }
  grid.resolution_m = in.number<float>();
  grid.width = in.number<std::uint32_t>();
  grid.height = in.number<std::uint32_t>();
  grid.origin = read_pose(in);
  in.numbers(grid.cells);
  return grid;
}

PointCloudMessage read_point_cloud(MessageReader in) {
  PointCloudMessage cloud;
  cloud.header = read_header(in);
  cloud.height = in.number<std::uint32_t>();
  cloud.width = in.number<std::uint32_t>();
  cloud.fields.resize(in.count(13));
  for (CloudField& field : cloud.fields) {
    field.name = in.text();
    field.offset = in.number<std::uint32_t>();
    field.type = in.number<std::uint8_t>();
    in.number<std::uint32_t>();
  }
  cloud.big_endian = in.number<std::uint8_t>() != 0;
  cloud.point_bytes = in.number<std::uint32_t>();
  cloud.row_bytes = in.number<std::uint32_t>();
  cloud.data = in.octets();
  return cloud;
}

}  // namespace parloc
