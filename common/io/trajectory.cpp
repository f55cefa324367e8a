#include "common/io/trajectory.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/file/line_reader.h"
#include "common/file/output_file.h"
#include "common/file/text_rows.h"
#include "common/math/portable64.h"

namespace parloc {

namespace {

constexpr double kMaxCoordinateM = 1e8;
constexpr double kMaxStampS = 1e12;            // microseconds stay exact in a double
constexpr double kQuaternionTolerance = 0.01;  // files have quaternions of 3 decimals too

StampedPose read_row(Fields& fields) {
  StampedPose row;
  row.stamp_s = fields.bounded("a time stamp", kMaxStampS);
  row.pose.x_m = fields.bounded("a finite position", kMaxCoordinateM);
  row.pose.y_m = fields.bounded("a finite position", kMaxCoordinateM);
  fields.bounded("a finite position", kMaxCoordinateM);
  double q[4];
  double norm2 = 0.0;
  for (double& component : q) {
    component = fields.bounded("a unit quaternion", 1.0 + kQuaternionTolerance);
    norm2 += component * component;
  }
  if (!(std::fabs(std::sqrt(norm2) - 1.0) <= kQuaternionTolerance)) {
    throw BrokenLine{fmt::format("expected a unit quaternion, found one of length {:.4g}", std::sqrt(norm2))};
  }
  if (!fields.empty()) fields.fail("8 numbers: timestamp x y z qx qy qz qw");
  // Parloc's own atan2: a start pose taken from a file is the same on every machine. Without the norm, the
  // same angle.
  row.pose.theta_rad = wrap64(portable_atan2_64(2.0 * (q[3] * q[2] + q[0] * q[1]),
                                                q[3] * q[3] + q[0] * q[0] - q[1] * q[1] - q[2] * q[2]));
  return row;
}

Trajectory read_rows(LineReader lines) {
  const Trajectory trajectory = read_text_rows(lines, read_row);
  if (trajectory.empty()) throw input_error(lines.name(), 0, "expected a pose, found none");
  return trajectory;
}

}  // namespace

Trajectory read_tum(const std::string& path) {
  return read_rows(LineReader::from_file(path));
}

Trajectory tum_from_text(const std::string& text, const std::string& name) {
  return read_rows(LineReader::from_text(text, name));
}

void write_tum(const std::string& path, const Trajectory& trajectory) {
  std::string text = "# timestamp x y z qx qy qz qw\n";
  for (const auto& [stamp_s, pose] : trajectory) {
    const SinCos64 half = portable_sincos64(0.5 * pose.theta_rad);
    text += fmt::format("{:.6f} {:.6f} {:.6f} 0 0 0 {:.9f} {:.9f}\n", stamp_s, pose.x_m, pose.y_m, half.sin,
                        half.cos);
  }
  replace_file(path, text);
}

}  // namespace parloc
