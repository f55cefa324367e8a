// The decoders of ROS messages on any bytes: the first one says which message and in which form; the rest is
// it.
#include <string_view>

#include "common/io/cloud_scan.h"
#include "common/ros/messages.h"
#include "common/ros/transform_tree.h"
#include "tests/fuzz/one_line.h"

namespace {

using parloc::fuzz::require;

void read_scan_of(parloc::MessageReader in, std::size_t size, bool multi_echo) {
  parloc::LaserScanMessage scan;
  multi_echo ? parloc::read_multi_echo_scan(in, scan) : parloc::read_laser_scan(in, scan);
  require(scan.ranges_m.size() <= size);
}

void read_transforms_of(parloc::MessageReader in) {
  parloc::TransformTree tree;
  for (const parloc::TransformMessage& transform : parloc::read_transforms(in)) {
    tree.add(transform, false);
    (void)tree.find("map", transform.child_frame, transform.header.stamp_s);
  }
}

void read_cloud_of(parloc::MessageReader in) {
  parloc::Scan scan;
  parloc::scan_from_cloud(parloc::read_point_cloud(in), {}, {0.0, 1.0}, scan);
  require(!scan.ranges_m.empty());
}

void read_any(int kind, parloc::MessageReader in, std::size_t size) {
  switch (kind) {
    case 0:
      read_scan_of(in, size, false);
      break;
    case 1:
      read_scan_of(in, size, true);
      break;
    case 2:
      (void)parloc::read_odometry(in);
      break;
    case 3:
      read_transforms_of(in);
      break;
    case 4:
      (void)parloc::read_pose_stamped(in);
      break;
    case 5:
      require(parloc::read_occupancy_grid(in).cells.size() <= size);
      break;
    default:
      read_cloud_of(in);
      break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    read_any(data[0] & 7, parloc::MessageReader(bytes, data[0] >= 128 ? "ros1" : "cdr"), size);
  } catch (const parloc::BrokenMessage& broken) {
    require(broken.why.find('\n') == std::string::npos);
  }
  return 0;
}
