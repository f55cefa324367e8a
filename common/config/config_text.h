// How names, values and limits of settings are written in messages and in YAML. Private to
// common/io/config*.cpp.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "common/config/settings_table.h"
#include "common/error.h"

namespace parloc::config_text {

/// "file:line: message" (line 0: the whole file), as a configuration error.
inline Error error(const std::string& file, std::size_t line, const std::string& message) {
  const std::string where = line > 0 ? fmt::format("{}:{}", file, line) : file;
  return Error(ErrorKind::config, where + ": " + message);
}

/// "motion.alpha1", or "particles" at the top level.
inline std::string full_name(std::string_view group, std::string_view key) {
  return group.empty() ? std::string(key) : fmt::format("{}.{}", group, key);
}
inline std::string full_name(const Setting& setting) {
  return full_name(setting.group, setting.key);
}

/// Text from a file, fit for one line of a message: at most 60 characters, no control characters.
inline std::string printable(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string out(text.substr(0, longest));
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return text.size() > longest ? out + "..." : out;
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
  return limits.above_low ? fmt::format("above {} and at most {}", limits.low, limits.high)
                          : fmt::format("{} to {}", limits.low, limits.high);
}

/// "seed or thrun"; "skip, dda or fixed_step".
template <class Choices>
std::string choices_text(const Choices& choices) {
  std::string text = choices[0].name;
  for (std::size_t i = 1; i < choices.size(); ++i) {
    text += (i + 1 < choices.size() ? ", " : " or ") + std::string(choices[i].name);
  }
  return text;
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
