#include "common/io/scan_file.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <limits>

#include "common/error.h"
#include "common/file/yaml_section.h"

namespace parloc {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kLongest_m = 1e6;
constexpr double kMostMount = 1000.0;  // [m], or [deg]

std::vector<float> ranges_of(YamlSection& root) {
  root.require("ranges");
  const YAML::Node node = root.node("ranges");
  if (!node.IsSequence() || node.size() == 0)
    throw root.error("ranges", "expected a list of ranges in metres, such as [1.25, 1.3, .nan]");
  std::vector<float> ranges;
  for (const YAML::Node& one : node) {
    double value = 0.0;
    if (!one.IsScalar() || !YAML::convert<double>::decode(one, value))
      throw root.error("ranges", "expected numbers alone, .nan or .inf; number " +
                                     std::to_string(ranges.size() + 1) + " is not one");
    ranges.push_back(static_cast<float>(value));
  }
  return ranges;
}

/// Of the LiDAR on the robot.
Pose mount_of(YamlSection& root) {
  double mount[3] = {0.0, 0.0, 0.0};
  if (root.has("mount")) root.numbers("mount", mount, 3);
  for (const double value : mount)
    if (std::fabs(value) > kMostMount) throw root.error("mount", "has a value beyond 1000");
  return compose({mount[0], mount[1], mount[2] * kDegree}, {});  // wraps the heading
}

Scan scan_of(const std::string& text, const std::string& name) {
  YamlSection root(yaml_document(text, name), name, "");
  Scan scan;
  double angle_min_deg = 0.0, angle_step_deg = 0.0;
  const double most = std::numeric_limits<double>::max();
  for (const char* key : {"angle_min_deg", "angle_step_deg"}) root.require(key);
  root.number("angle_min_deg", angle_min_deg, -720.0, 720.0);
  root.number("angle_step_deg", angle_step_deg, -360.0, 360.0);
  root.number("range_min", scan.range_min_m, 0.0, kLongest_m);
  root.number("range_max", scan.range_max_m, 1e-3, kLongest_m);
  root.number("stamp", scan.stamp_s, -most, most);
  root.text("sensor", scan.sensor);
  if (root.has("range_max") && scan.range_min_m >= scan.range_max_m)
    throw root.error("range_min", "must be below range_max");
  scan.T_base_sensor = mount_of(root);
  scan.ranges_m = ranges_of(root);
  root.finish();
  scan.angle_min_rad = angle_min_deg * kDegree;
  scan.angle_step_rad = angle_step_deg * kDegree;
  return scan;
}

}  // namespace

Scan scan_from_text(const std::string& text, const std::string& name) {
  try {
    return scan_of(text, name);
  } catch (const Error& e) {  // it is data, not a configuration
    throw Error(ErrorKind::input, e.what());
  }
}

Scan read_scan(const std::string& path) {
  std::string text;
  try {
    text = read_small_file(path);
  } catch (const Error& e) {
    throw Error(ErrorKind::input, e.what());
  }
  return scan_from_text(text, path);
}

}  // namespace parloc
