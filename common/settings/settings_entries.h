// What a file says, key by key, before anything is made of the values.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/settings/setting.h"

namespace parloc {

/// "key: value" as written. The key is a known one.
struct SettingsEntry {
  std::string group;  ///< Empty at the top level.
  std::string key;
  std::string value;
  std::size_t line = 0;
  bool quoted = false;  ///< 'value' or "value": a text, not a number.
  bool empty = false;   ///< Nothing, or null.

  std::string name() const { return group.empty() ? key : group + "." + key; }
};

/// The longest file that is read, in bytes; a complete one has 8 KiB.
inline constexpr std::size_t kLongestSettings = 64 * 1024;

/// The entries in file order. Throws Error{config} with file:line for text that is too long, binary or not
/// YAML, for a key that `known` does not have or that comes twice, a list or group where a value belongs, an
/// anchor, alias or type tag.
std::vector<SettingsEntry> settings_entries(const std::string& text, const std::string& file,
                                            const Settings& known);

}  // namespace parloc
