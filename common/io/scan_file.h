// One LiDAR scan in a small YAML file, for `parloc locate` (docs/locate.md).
#pragma once

#include <string>

#include "common/io/log.h"

namespace parloc {

/// angle_min_deg, angle_step_deg and ranges [m] (.nan and .inf allowed); may be left out: range_min,
/// range_max [m], mount [x, y in m, heading in deg], stamp [s], sensor. Throws Error{input} with file:line
/// for an unknown key, a wrong type or value, no range, or a file that cannot be read.
Scan read_scan(const std::string& yaml_path);
/// The same from memory; `name` stands for the file.
Scan scan_from_text(const std::string& text, const std::string& name);

}  // namespace parloc
