#include "common/io/scan_file.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string_view>

#include "common/error.h"
#include "common/file/text_fields.h"
#include "common/file/yaml_section.h"
#include "common/math/angle_units.h"

namespace parloc {
namespace {

constexpr double kLongest_m = 1e6;
constexpr double kMostMount = 1000.0;  // [m], or [deg]
constexpr YamlRules kRules{"a scan", 1024 * 1024, ErrorKind::input};

/// A number as YAML writes it: .nan and .inf, with a sign, too; quotes do not matter.
bool parse_range(std::string_view text, double& value) {
  const double inf = std::numeric_limits<double>::infinity();
  const bool negative = text.substr(0, 1) == "-";
  const std::string_view size = text.substr(negative || text.substr(0, 1) == "+" ? 1 : 0);
  if (text == ".nan" || text == ".NaN" || text == ".NAN") {
    value = std::numeric_limits<double>::quiet_NaN();
  } else if (size == ".inf" || size == ".Inf" || size == ".INF") {
    value = negative ? -inf : inf;
  } else {  // from_chars knows "inf" and "nan", which YAML takes for texts
    const bool digits = !size.empty() && size.find_first_of("0123456789.") == 0;
    return digits && parse_number(text, value) == std::errc{};
  }
  return true;
}

std::vector<float> ranges_of(const YamlSection& top) {
  top.require("ranges");
  std::vector<float> ranges;
  for (const YamlNode& one : top.list("ranges", "a list of ranges in metres, such as [1.25, 1.3, .nan]", 1)) {
    double value = 0.0;
    if (!parse_range(one.text, value)) {
      throw top.error_at(one.line,
                         fmt::format("ranges: expected numbers alone, .nan or .inf; number {} is {}",
                                     ranges.size() + 1, described(one.kind, one.text)));
    }
    ranges.push_back(static_cast<float>(value));
  }
  return ranges;
}

/// Of the LiDAR on the robot.
Pose mount_of(const YamlSection& top) {
  double mount[3] = {};
  top.numbers("mount", mount, 3, -kMostMount, kMostMount, "[x, y in m, heading in deg]");
  return compose({mount[0], mount[1], mount[2] * kRadPerDeg}, {});  // wraps the heading
}

}  // namespace

Scan scan_from_text(const std::string& text, const std::string& name) {
  const YamlSection top(text, name, kRules);
  Scan scan;
  double angle_min_deg = 0.0, angle_step_deg = 0.0;
  const double most = std::numeric_limits<double>::max();
  for (const char* key : {"angle_min_deg", "angle_step_deg"}) top.require(key);
  top.number("angle_min_deg", angle_min_deg, -720.0, 720.0);
  top.number("angle_step_deg", angle_step_deg, -360.0, 360.0);
  top.number("range_min", scan.range_min_m, 0.0, kLongest_m);
  top.number("range_max", scan.range_max_m, 1e-3, kLongest_m);
  top.number("stamp", scan.stamp_s, -most, most);
  top.text("sensor", scan.sensor);
  scan.T_base_sensor = mount_of(top);
  scan.ranges_m = ranges_of(top);
  top.finish();
  if (top.has("range_max") && scan.range_min_m >= scan.range_max_m)
    throw top.error("range_min", "must be below range_max");
  scan.angle_min_rad = angle_min_deg * kRadPerDeg;
  scan.angle_step_rad = angle_step_deg * kRadPerDeg;
  return scan;
}

Scan read_scan(const std::string& path) {
  return scan_from_text(read_yaml_file(path, kRules), path);
}

}  // namespace parloc
