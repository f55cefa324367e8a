// The table of all settings, and parts of reading a file that only those know who read one.
#pragma once

#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/settings/setting.h"

namespace parloc {

/// In printed order; `config` outlives it.
Settings settings_of(Config& config);
/// Limits of every setting first, then the rules between settings.
std::optional<Violation> first_violation(const Config& config);
/// config_from_text() of a file that is not nav2's.
Config parloc_config_from_text(const std::string& text, const std::string& name, const Config& base);

}  // namespace parloc
