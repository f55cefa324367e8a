// Finds the parameters of nav2's amcl in a parameter file of ROS 2.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/file/yaml_reader.h"

namespace parloc {

struct Nav2Value {
  std::string name;  ///< Groups in groups are "initial_pose.x".
  YamlKind kind;
  std::string text;
  std::size_t line;
};

/// The parameters of one amcl.
struct Nav2File {
  std::string node;  ///< "/robot1/amcl"
  std::vector<Nav2Value> values;
};

/// Nothing if no group of the text is named ros__parameters: it is not of ROS 2. Those of "/**" count for
/// amcl unless its own say otherwise. Throws Error{config} with file:line for text that is not YAML or longer
/// than 1 MiB, and for a file without an amcl or with several.
std::optional<Nav2File> nav2_file(const std::string& text, const std::string& name);

inline constexpr std::size_t kLongestNav2File = 1024 * 1024;  ///< Those of nav2 have 10 to 30 KiB.

}  // namespace parloc
