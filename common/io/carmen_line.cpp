// Scans as lines of a CARMEN log.
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>

#include "common/io/log.h"

namespace parloc {

namespace {

/// The view whose share by gap is `step_rad` to the bit for a reader, if there is one.
double exact_view(double step_rad, double view_rad, std::size_t beams) {
  const double gaps = static_cast<double>(beams) - 1.0;
  for (const double near :
       {view_rad, std::nextafter(view_rad, 0.0), std::nextafter(view_rad, 2.0 * view_rad)})
    if (near / gaps == step_rad) return near;
  return view_rad;
}

}  // namespace

std::string carmen_line(const LogRecord& record, CarmenDigits digits) {
  const Scan& scan = record.scan;
  const std::size_t n = scan.ranges_m.size();
  // No line can say that a LiDAR is upside down, but one may count its angles clockwise.
  const double sign = scan.upside_down ? -1.0 : 1.0;
  const double min_rad = sign * scan.angle_min_rad, step_rad = sign * scan.angle_step_rad;
  double fov_rad = n > 0 ? step_rad * static_cast<double>(n - 1) : 0.0;
  if (digits == CarmenDigits::all && n > 1) fov_rad = exact_view(step_rad, fov_rad, n);
  const Pose& robot = record.odometry;
  const Pose laser = compose(robot, scan.T_base_sensor);
  std::string line;
  auto out = std::back_inserter(line);
  const auto put = [&](auto value, int decimals) {
    if (digits == CarmenDigits::all)
      fmt::format_to(out, " {}", value);
    else
      fmt::format_to(out, " {:.{}f}", value, decimals);
  };
  const char last = scan.sensor.empty() ? '0' : scan.sensor.back();
  const bool numbered =
      scan.sensor.size() == 11 && scan.sensor.starts_with("robotlaser") && last >= '1' && last <= '9';
  fmt::format_to(out, "ROBOTLASER{} 0", numbered ? last : '1');
  for (const double angle_rad : {min_rad, fov_rad, step_rad}) put(angle_rad, 9);
  put(scan.range_max_m, 6);
  fmt::format_to(out, " 0.010000 0 {}", n);
  for (const float range_m : scan.ranges_m) put(range_m, 4);
  fmt::format_to(out, " 0");
  for (const Pose& pose : {laser, robot})
    for (const double value : {pose.x_m, pose.y_m, pose.theta_rad}) put(value, 9);
  fmt::format_to(out, " 0 0 0 0 0");
  put(scan.stamp_s, 6);
  fmt::format_to(out, " parloc");
  put(scan.stamp_s, 6);
  return line;
}

}  // namespace parloc
