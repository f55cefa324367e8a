// The parameters of nav2's localization node, nav2_amcl, and what becomes of each here. docs/nav2.md.
#pragma once

#include <string_view>
#include <vector>

namespace parloc {

enum class Nav2Fate {
  same,     ///< Means the same as a setting here, in the same unit.
  adapted,  ///< Nearly: common/config/nav2_config.cpp says how.
  none,     ///< Has no meaning for a log.
};

struct Nav2Parameter {
  const char* name;
  const char* default_text;  ///< nav2's, which is not used: what a file does not say has parloc's default.
  Nav2Fate fate;
  const char* setting;  ///< Of parloc; empty if there is none.
  const char* why;      ///< What is different, or why it has no meaning; may be empty.
};

/// All of them, by name, with those that every node of nav2 has. Source: amcl_node.cpp of nav2_amcl, and
/// lifecycle_node.cpp of nav2_util.
const std::vector<Nav2Parameter>& nav2_parameters();
/// Null if there is none of that name.
const Nav2Parameter* nav2_parameter(std::string_view name);

}  // namespace parloc
