// From the groups of a file to the values of settings.
#pragma once

#include <optional>

#include "common/file/yaml_section.h"
#include "common/settings/setting.h"

namespace parloc {

/// Gives the settings that the file has their value. Throws as YamlSection for a wrong type or a value out of
/// its range; top.finish() then for a key that is none of them.
void read_settings(const YamlSection& top, const Settings& settings);
/// Only the one of that name.
void read_setting(const YamlSection& top, const Settings& settings, const std::string& name);
/// Throws at the line of the setting to blame, if there is one.
void require_none(const YamlSection& top, const std::optional<Violation>& violation);

}  // namespace parloc
