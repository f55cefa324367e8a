#include "common/io/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/file/line_reader.h"
#include "common/file/output_file.h"
#include "common/file/text_rows.h"
#include "common/io/log_limits.h"
#include "common/math/portable64.h"

namespace parloc {

namespace {

constexpr double kQuaternionTolerance = 0.01;  // files have quaternions of 3 decimals too

StampedPose read_row(Fields& fields) {
  StampedPose row;
  row.stamp_s = fields.bounded("a time stamp", kMostStamp_s);
  row.pose.x_m = fields.bounded("a finite position", kMostCoordinate_m);
  row.pose.y_m = fields.bounded("a finite position", kMostCoordinate_m);
  fields.bounded("a finite position", kMostCoordinate_m);
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

// What the first line of a CARMEN log may begin with, but for comments.
bool is_carmen_name(std::string_view name) {
  constexpr std::array names = {"FLASER",  "RLASER",     "ODOM",     "PARAM",   "SYNC",   "COMMENT",
                                "TRUEPOS", "ROBOTLASER", "RAWLASER", "NMEAGGA", "NMEARMC"};
  return std::any_of(names.begin(), names.end(), [&](std::string_view known) {
    const std::string_view rest = name.substr(std::min(known.size(), name.size()));
    return name.substr(0, known.size()) == known &&
           (rest.empty() || (rest.size() == 1 && rest[0] >= '0' && rest[0] <= '9'));
  });
}

// FLASER n r_1 .. r_n x y theta odom_x odom_y odom_theta stamp host logger_stamp; nothing of other messages.
std::optional<StampedPose> read_flaser(Fields& fields) {
  if (fields.text() != "FLASER") return std::nullopt;
  const auto ranges = fields.number<std::size_t>("a number of ranges");
  if (ranges > fields.bytes_left() / 2)
    throw BrokenLine{fmt::format("expected a number of ranges, found {}, more than the line holds", ranges)};
  for (std::size_t i = 0; i < ranges; ++i) fields.number<float>("a range");
  StampedPose row;
  row.pose.x_m = fields.bounded("a finite position", kMostCoordinate_m);
  row.pose.y_m = fields.bounded("a finite position", kMostCoordinate_m);
  row.pose.theta_rad = wrap64(fields.bounded("a finite heading", kMostHeading_rad));
  for (int i = 0; i < 3; ++i) fields.number<double>("odometry");
  row.stamp_s = fields.bounded("a time stamp", kMostStamp_s);
  fields.text();
  fields.text();
  if (!fields.empty()) fields.fail("the end of the line after time stamp, host and logger time stamp");
  return row;
}

Trajectory read_rows(LineReader lines) {
  std::optional<bool> is_carmen;
  const auto rows = read_text_rows(lines, [&](Fields& fields) {
    if (!is_carmen) is_carmen = is_carmen_name(Fields(fields).text());
    return *is_carmen ? read_flaser(fields) : std::optional<StampedPose>(read_row(fields));
  });
  Trajectory trajectory;
  for (const auto& row : rows)
    if (row) trajectory.push_back(*row);
  if (trajectory.empty())
    throw input_error(lines.name(), 0,
                      is_carmen.value_or(false) ? "expected a FLASER line with a pose, found none"
                                                : "expected a pose, found none");
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
