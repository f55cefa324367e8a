// How names, values and limits of settings are written in messages and in YAML. Private to
// common/config.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "common/config/settings_table.h"
#include "common/error.h"
#include "common/file/yaml_section.h"

namespace parloc::config_text {

using parloc::choices_text;
using parloc::printable;

/// "motion.alpha1", or "particles" at the top level.
inline std::string full_name(std::string_view group, std::string_view key) {
  return group.empty() ? std::string(key) : fmt::format("{}.{}", group, key);
}
inline std::string full_name(const Setting& setting) {
  return full_name(setting.group, setting.key);
}

/// What a key below `lidars` may be.
inline constexpr const char* kLidarNames = "expected 1 to 40 letters, digits, '_' or '-'";
inline bool is_lidar_name(std::string_view name) {
  if (name.empty() || name.size() > 40) return false;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '_' && c != '-') return false;
  }
  return true;
}

/// "1 to 4096", or "above 0 and at most 1".
template <class Number>
std::string limits_text(const Limits<Number>& limits) {
  return parloc::limits_text(limits.low, limits.high, limits.above_low);
}

/// The name of an enumeration's value; null for a value that is none of the choices.
template <class Enum, class Choices>
const char* choice_name(Enum value, const Choices& choices) {
  for (const auto& choice : choices) {
    if (choice.value == value) return choice.name;
  }
  return nullptr;
}

/// False for NaN too.
template <class Number>
bool within(Number value, const Limits<Number>& limits) {
  return value >= limits.low && value <= limits.high && !(limits.above_low && value == limits.low);
}

/// "motion.alpha1 must be 0 to 100, got -1".
template <class Number>
std::string limits_message(const Setting& setting, Number value, const Limits<Number>& limits) {
  return fmt::format("{} must be {}, got {}", full_name(setting), limits_text(limits), value);
}

}  // namespace parloc::config_text
