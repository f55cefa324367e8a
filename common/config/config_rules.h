// The first rule that a configuration breaks, for the reader, which knows the line. Private to
// common/config.
#pragma once

#include <optional>
#include <string>

#include "common/filter/config.h"

namespace parloc {

struct ConfigViolation {
  std::string name;     ///< The setting to blame: "sensor.z_hit".
  std::string message;  ///< One line that names it too.
};

/// Limits of every setting first, then the rules between settings. Empty: the configuration is sound.
std::optional<ConfigViolation> first_violation(const FilterConfig& config);

}  // namespace parloc
