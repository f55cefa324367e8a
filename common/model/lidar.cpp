#include "common/model/lidar.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/error.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

double above_zero_or(double value, double otherwise) {
  return value > 0 ? value : otherwise;
}

void check_each_beam(const Scan& scan, const std::vector<double>& values, const char* what) {
  if (values.empty()) return;
  if (values.size() != scan.ranges_m.size())
    throw Error(ErrorKind::input, "scan " + scan.sensor + ": expected one of " + what + " per range (" +
                                      std::to_string(scan.ranges_m.size()) + "), got " +
                                      std::to_string(values.size()));
  for (const double v : values)
    if (!std::isfinite(v))
      throw Error(ErrorKind::input, "scan " + scan.sensor + ": expected " + what + " that are finite");
}

/// Numbers of a scan that count, since `lidar` says nothing over them.
void check_numbers(const Scan& scan, const LidarConfig& lidar) {
  const auto expect = [&](bool counts, double value, const char* what) {
    if (counts && !std::isfinite(value))
      throw Error(ErrorKind::input, "scan " + scan.sensor + ": expected " + what + " that is finite, got " +
                                        std::to_string(value));
  };
  const bool even = scan.bearings_rad.empty();
  expect(true, scan.stamp_s, "a stamp_s");
  expect(!lidar.x, scan.T_base_sensor.x_m, "a T_base_sensor.x_m");
  expect(!lidar.y, scan.T_base_sensor.y_m, "a T_base_sensor.y_m");
  expect(!lidar.yaw, scan.T_base_sensor.theta_rad, "a T_base_sensor.theta_rad");
  expect(even && !lidar.angle_min, scan.angle_min_rad, "an angle_min_rad");
  expect((even || lidar.angle_min) && !lidar.angle_step, scan.angle_step_rad, "an angle_step_rad");
  expect(!lidar.min_range, scan.range_min_m, "a range_min_m");
  expect(!lidar.max_range, scan.range_max_m, "a range_max_m");
  expect(!lidar.scan_time && scan.beam_times_s.empty(), scan.scan_time_s, "a scan_time_s");
}

}  // namespace

const LidarConfig* find_lidar(const std::vector<LidarConfig>& lidars, const std::string& name) {
  for (const LidarConfig& lidar : lidars)
    if (lidar.name == name) return &lidar;
  return nullptr;
}

LidarSetup lidar_setup(const Scan& scan, const ScanConfig& config, const LidarConfig* lidar) {
  static const LidarConfig nothing;
  const LidarConfig& l = lidar != nullptr ? *lidar : nothing;
  check_numbers(scan, l);
  check_each_beam(scan, scan.bearings_rad, "bearings_rad");
  check_each_beam(scan, scan.beam_times_s, "beam_times_s");
  const auto& b = scan.bearings_rad;
  if (!std::is_sorted(b.begin(), b.end()) && !std::is_sorted(b.rbegin(), b.rend()))
    throw Error(ErrorKind::input, "scan " + scan.sensor + ": expected bearings_rad in order");

  LidarSetup s;
  s.T_base_sensor = {l.x.value_or(scan.T_base_sensor.x_m), l.y.value_or(scan.T_base_sensor.y_m),
                     l.yaw.value_or(scan.T_base_sensor.theta_rad)};
  s.upside_down = l.upside_down ? *l.upside_down : l.flipped.value_or(scan.upside_down);
  s.own_bearings = !b.empty() && !l.angle_min && !l.angle_step;
  s.angle_min_rad = l.angle_min.value_or(b.empty() ? scan.angle_min_rad : b.front());
  s.angle_step_rad = l.angle_step.value_or(scan.angle_step_rad);
  if (!l.mask.empty()) s.mask = &l.mask;
  s.range_min_m = l.min_range.value_or(above_zero_or(scan.range_min_m, config.laser_min_range));
  s.range_max_m = l.max_range.value_or(above_zero_or(scan.range_max_m, config.laser_max_range));
  s.max_beams = l.max_beams.value_or(config.max_beams);
  s.zero_policy = l.zero_policy.value_or(config.zero_policy);
  s.scan_time_s = l.scan_time.value_or(above_zero_or(scan.scan_time_s, config.scan_time));
  s.stamp_at = l.stamp_at.value_or(config.stamp_at);
  s.own_times = !l.scan_time && !scan.beam_times_s.empty();
  return s;
}

double beam_time_s(const Scan& scan, const LidarSetup& setup, std::size_t i) {
  if (setup.own_times) return scan.beam_times_s[i];
  if (scan.ranges_m.size() < 2) return 0.0;
  const double done = static_cast<double>(i) / static_cast<double>(scan.ranges_m.size() - 1);
  const double at_stamp = setup.stamp_at == StampAt::first    ? 0.0
                          : setup.stamp_at == StampAt::middle ? 0.5
                                                              : 1.0;
  return setup.scan_time_s * (done - at_stamp);
}

bool takes_time(const Scan& scan, const LidarSetup& setup) {
  const auto& times = scan.beam_times_s;
  if (setup.own_times) return std::any_of(times.begin(), times.end(), [](double t) { return t != 0.0; });
  return setup.scan_time_s > 0.0 && scan.ranges_m.size() > 1;
}

double latest_beam_s(const Scan& scan, const LidarSetup& setup) {
  if (scan.ranges_m.empty()) return 0.0;
  if (setup.own_times)
    return std::max(0.0, *std::max_element(scan.beam_times_s.begin(), scan.beam_times_s.end()));
  return std::max(0.0, beam_time_s(scan, setup, scan.ranges_m.size() - 1));
}

double beam_bearing_rad(const Scan& scan, const LidarSetup& setup, std::size_t i) {
  const double bearing_rad = setup.own_bearings
                                 ? scan.bearings_rad[i]
                                 : setup.angle_min_rad + static_cast<double>(i) * setup.angle_step_rad;
  return setup.upside_down ? -bearing_rad : bearing_rad;
}

bool is_masked(const Scan& scan, const LidarSetup& setup, std::size_t i) {
  if (setup.mask == nullptr) return false;
  const double bearing_rad = beam_bearing_rad(scan, setup, i);
  const auto turn = [](double angle_rad) {  // to [0, 2 pi)
    const double wrapped = wrap64(angle_rad);
    return wrapped < 0.0 ? wrapped + 2.0 * kPi : wrapped;
  };
  // An end that a bearing meets but for rounding belongs to the interval.
  constexpr double rounding_rad = 1e-9;
  return std::any_of(setup.mask->begin(), setup.mask->end(), [&](const AngleInterval& masked) {
    return turn(bearing_rad - masked.from + rounding_rad) <=
           turn(masked.to - masked.from) + 2.0 * rounding_rad;
  });
}

}  // namespace parloc
