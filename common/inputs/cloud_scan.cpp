#include "common/inputs/cloud_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/math/portable64.h"

namespace parloc {

namespace {

constexpr std::size_t kBeams = 720;
constexpr std::uint8_t kFloat32 = 7, kFloat64 = 8;

/// Where a coordinate lies in a point.
struct Coordinate {
  std::uint32_t offset;
  bool is_double;
};

Coordinate coordinate(const PointCloudMessage& cloud, const char* name) {
  for (const CloudField& field : cloud.fields) {
    if (field.name != name) continue;
    const std::uint32_t size = field.type == kFloat64 ? 8 : 4;
    if ((field.type != kFloat32 && field.type != kFloat64) || field.offset > cloud.point_bytes ||
        size > cloud.point_bytes - field.offset)
      throw BrokenMessage{fmt::format("expected {} of a cloud's points as float32 or float64", name)};
    return {field.offset, field.type == kFloat64};
  }
  throw BrokenMessage{fmt::format("expected a cloud with a field {}", name)};
}

double value(const char* point, const Coordinate& c, bool swap) {
  char bytes[8];
  const std::size_t size = c.is_double ? 8 : 4;
  for (std::size_t k = 0; k < size; ++k) bytes[k] = point[c.offset + (swap ? size - 1 - k : k)];
  if (c.is_double) {
    double wide;
    std::memcpy(&wide, bytes, sizeof wide);
    return wide;
  }
  float narrow;
  std::memcpy(&narrow, bytes, sizeof narrow);
  return narrow;
}

}  // namespace

void scan_from_cloud(const PointCloudMessage& cloud, const RigidTransform& T_base_sensor,
                     const CloudBand& band, Scan& scan) {
  const Coordinate x = coordinate(cloud, "x"), y = coordinate(cloud, "y"), z = coordinate(cloud, "z");
  const std::uint64_t rows = cloud.height, per_row = cloud.width;
  if (rows > 0 &&
      (per_row * cloud.point_bytes > cloud.row_bytes || rows * cloud.row_bytes > cloud.data.size()))
    throw BrokenMessage{
        fmt::format("expected a cloud of {} x {} points, found {} bytes", rows, per_row, cloud.data.size())};
  const bool swap = cloud.big_endian != (std::endian::native == std::endian::big);
  const Pose upright = planar(T_base_sensor);
  scan.angle_min_rad = -kPi;
  scan.angle_step_rad = 2.0 * kPi / static_cast<double>(kBeams);
  scan.range_min_m = scan.range_max_m = scan.scan_time_s = 0.0;
  scan.T_base_sensor = upright;
  scan.ranges_m.assign(kBeams, std::numeric_limits<float>::infinity());
  for (std::uint64_t row = 0; row < rows; ++row) {
    const char* point = cloud.data.data() + row * cloud.row_bytes;
    for (std::uint64_t k = 0; k < per_row; ++k, point += cloud.point_bytes) {
      const auto in_base =
          transformed(T_base_sensor, {value(point, x, swap), value(point, y, swap), value(point, z, swap)});
      if (!(in_base[2] >= band.low_m && in_base[2] <= band.high_m)) continue;
      const Pose seen = relative({in_base[0], in_base[1], 0.0}, upright);
      const double range_m = std::sqrt(seen.x_m * seen.x_m + seen.y_m * seen.y_m);
      if (!(range_m > 0.0) || !std::isfinite(range_m)) continue;
      const double beam = (portable_atan2_64(seen.y_m, seen.x_m) + kPi) / scan.angle_step_rad;
      float& nearest = scan.ranges_m[static_cast<std::size_t>(std::llround(beam)) % kBeams];
      nearest = std::min(nearest, static_cast<float>(range_m));
    }
  }
}

}  // namespace parloc
