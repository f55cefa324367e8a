// What a configuration file says, key by key, before anything is made of the values. Private to
// common/io/config*.cpp.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace parloc {

/// "key: value" as written. The key is a known one.
struct ConfigEntry {
  std::string group;  ///< Empty at the top level.
  std::string key;
  std::string value;
  std::size_t line = 0;
  bool quoted = false;  ///< 'value' or "value": a text, not a number.
  bool empty = false;   ///< Nothing, or null.
};

/// The longest configuration that is read, in bytes; a complete one has 5 KiB.
inline constexpr std::size_t kLongestConfig = 64 * 1024;

/// The entries in file order. Throws Error{config} with file:line for text that is too long, binary or not
/// YAML, for an unknown or duplicate key, a list or group where a value belongs, an anchor, alias or type
/// tag.
std::vector<ConfigEntry> config_entries(const std::string& text, const std::string& file);

}  // namespace parloc
