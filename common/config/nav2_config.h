// From a parameter file of nav2 to a configuration.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/math/pose.h"

namespace parloc {

/// What became of one parameter that a file has.
struct Nav2Line {
  enum class Kind { taken, no_meaning, unknown };
  Kind kind;
  std::string name;
  std::string value;  ///< As written.
  std::string text;   ///< "sensor.sigma_hit: 0.2", or why there is none.
};

/// A configuration file, of parloc or of nav2.
struct ConfigFile {
  Config config;
  std::string nav2_node;           ///< "/robot1/amcl"; empty: a file of parloc.
  std::vector<Nav2Line> lines;     ///< In the file's order, shares and the start last.
  std::optional<Pose> nav2_start;  ///< In the map frame, with set_initial_pose: true.
};

/// As read_config(), which says which files are nav2's. What such a file does not say has the value that it
/// has in `base`. Throws Error{config} with file:line besides for a file of nav2 without an amcl or with
/// several.
ConfigFile read_config_file(const std::string& path, const Config& base = {});
ConfigFile config_file_from_text(const std::string& text, const std::string& name, const Config& base = {});

/// For a file of nav2: how many parameters were taken, and the others by name. Two or three lines.
std::vector<std::string> nav2_summary(const ConfigFile& file, const std::string& path);
/// Every parameter that the file has, one line each.
std::vector<std::string> nav2_listing(const ConfigFile& file);

}  // namespace parloc
