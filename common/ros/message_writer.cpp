#include "common/ros/message_writer.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "common/error.h"
#include "common/math/portable64.h"

namespace parloc {

RosTime ros_time(double stamp_s) {
  const double whole_s = std::floor(stamp_s);
  if (!(whole_s >= std::numeric_limits<std::int32_t>::min() &&
        whole_s < std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorKind::input,
                fmt::format("a stamp of {} s: a ROS message holds seconds up to 2147483646", stamp_s));
  const double part_s = stamp_s - whole_s;
  // Clocks are written with microseconds, and a double of today's has no more: the digits behind are of its
  // rounding, and left out where that gives the same double.
  std::int64_t part_ns = std::llround(part_s * 1e6) * 1000;
  if (seconds_of(static_cast<std::int64_t>(whole_s), static_cast<std::uint32_t>(part_ns)) != stamp_s)
    part_ns = std::llround(part_s * 1e9);
  const bool carry = part_ns >= 1'000'000'000;
  return {static_cast<std::int32_t>(whole_s) + (carry ? 1 : 0),
          static_cast<std::uint32_t>(carry ? part_ns - 1'000'000'000 : part_ns)};
}

void MessageWriter::text(std::string_view text) {
  count(text.size() + 1);
  bytes_ += text;
  bytes_ += '\0';
}

namespace {

void put(MessageWriter& out, const MessageHeader& header) {
  const RosTime stamp = ros_time(header.stamp_s);
  out.number(stamp.seconds);
  out.number(stamp.nanoseconds);
  out.text(header.frame);
}

void put(MessageWriter& out, const RigidTransform& pose) {
  for (const double value : {pose.x_m, pose.y_m, pose.z_m, pose.qx, pose.qy, pose.qz, pose.qw})
    out.number(value);
}

void put_zeros(MessageWriter& out, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) out.number(0.0);
}

constexpr std::size_t kCovariance = 36, kTwist = 6;

}  // namespace

MessageWriter write_laser_scan(const LaserScanMessage& scan) {
  MessageWriter out;
  put(out, scan.header);
  for (const float value : {scan.angle_min_rad, scan.angle_max_rad, scan.angle_step_rad, scan.time_step_s,
                            scan.scan_time_s, scan.range_min_m, scan.range_max_m})
    out.number(value);
  out.numbers(scan.ranges_m);
  out.count(0);  // intensities
  return out;
}

MessageWriter write_odometry(const OdometryMessage& odometry) {
  MessageWriter out;
  put(out, odometry.header);
  out.text(odometry.child_frame);
  put(out, odometry.pose);
  put_zeros(out, kCovariance + kTwist + kCovariance);
  return out;
}

MessageWriter write_transforms(const std::vector<TransformMessage>& transforms) {
  MessageWriter out;
  out.count(transforms.size());
  for (const TransformMessage& transform : transforms) {
    put(out, transform.header);
    out.text(transform.child_frame);
    put(out, transform.T_parent_child);
  }
  return out;
}

MessageWriter write_occupancy_grid(const OccupancyGridMessage& grid) {
  MessageWriter out;
  put(out, grid.header);
  const RosTime loaded = ros_time(grid.header.stamp_s);
  out.number(loaded.seconds);
  out.number(loaded.nanoseconds);
  out.number(static_cast<float>(grid.resolution_m));
  out.number(grid.width);
  out.number(grid.height);
  put(out, grid.origin);
  out.numbers(grid.cells);
  return out;
}

MessageWriter write_pose(const MessageHeader& header, const Pose& pose) {
  MessageWriter out;
  put(out, header);
  put(out, spatial(pose));
  return out;
}

MessageWriter write_pose_with_covariance(const MessageHeader& header, const Pose& pose,
                                         const double (&covariance)[9]) {
  MessageWriter out = write_pose(header, pose);
  // Of x, y, z and the turns about them: what does not move has no variance.
  constexpr std::size_t place[3] = {0, 1, 5};
  std::array<double, kCovariance> whole{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      whole[place[row] * 6 + place[column]] = covariance[row * 3 + column];
  for (const double value : whole) out.number(value);
  return out;
}

MessageWriter write_path(const MessageHeader& header, const std::vector<StampedPose>& poses) {
  MessageWriter out;
  put(out, header);
  out.count(poses.size());
  for (const StampedPose& pose : poses) {
    put(out, {pose.stamp_s, header.frame});
    put(out, spatial(pose.pose));
  }
  return out;
}

MessageWriter write_particles(const MessageHeader& header, const std::vector<WeightedPose>& particles) {
  MessageWriter out;
  put(out, header);
  out.count(particles.size());
  for (const WeightedPose& particle : particles) {
    put(out, spatial(particle.pose));
    out.number(particle.weight);
  }
  return out;
}

MessageWriter write_diagnostics(const DiagnosticMessage& message) {
  MessageWriter out;
  put(out, message.header);
  out.count(1);
  out.number(static_cast<std::uint8_t>(message.level));
  out.text(message.name);
  out.text(message.message);
  out.text("");  // no hardware
  out.count(message.values.size());
  for (const auto& [key, value] : message.values) {
    out.text(key);
    out.text(value);
  }
  return out;
}

namespace {

RigidTransform turned(const Pose& pose, double sine, double cosine, bool upside_down) {
  if (upside_down) return {pose.x_m, pose.y_m, 0.0, cosine, sine, 0.0, 0.0};
  return {pose.x_m, pose.y_m, 0.0, 0.0, 0.0, sine, cosine};
}

/// What a reader makes of its heading.
double heading_read(RigidTransform transform) {
  normalise(transform);
  return planar(transform).theta_rad;
}

double moved_by(double value, int places) {
  for (; places > 0; --places) value = std::nextafter(value, 2.0);
  for (; places < 0; ++places) value = std::nextafter(value, -2.0);
  return value;
}

}  // namespace

// Several pairs of doubles next to each other stand for about the same angle, and readers round: of those the
// one is taken that comes back. The smaller of sine and cosine has the finer steps.
RigidTransform spatial(const Pose& pose, bool upside_down) {
  const double heading_rad = wrap64(pose.theta_rad);
  const SinCos64 half = portable_sincos64(0.5 * heading_rad);
  const bool sine_is_finer = std::fabs(half.sin) < std::fabs(half.cos);
  RigidTransform best = turned(pose, half.sin, half.cos, upside_down);
  double least = std::fabs(wrap64(heading_read(best) - heading_rad));
  constexpr int most = 4;
  for (int coarse = -most; coarse <= most; ++coarse) {
    for (int fine = -most; fine <= most && least > 0.0; ++fine) {
      const double sine = moved_by(half.sin, sine_is_finer ? fine : coarse);
      const double cosine = moved_by(half.cos, sine_is_finer ? coarse : fine);
      const RigidTransform near = turned(pose, sine, cosine, upside_down);
      const double off = std::fabs(wrap64(heading_read(near) - heading_rad));
      if (off < least) best = near, least = off;
    }
  }
  return best;
}

}  // namespace parloc
