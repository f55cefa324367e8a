// Booleans of YAML 1.1, for files that other programs write.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace parloc {

inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return lower;
}

/// true, yes, on, y and their opposites, in the three ways to write each that yaml-cpp knows: "no", "No",
/// "NO". Nothing for any other text.
inline std::optional<bool> yaml_boolean(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const std::string lower = lower_case(text), rest = text.substr(1);
  const bool rest_is_lower = rest == lower.substr(1);
  const bool rest_is_upper =
      std::none_of(rest.begin(), rest.end(), [](char c) { return c >= 'a' && c <= 'z'; });
  if (!rest_is_lower && (!rest_is_upper || text[0] == lower[0])) return std::nullopt;
  for (const char* yes : {"true", "yes", "on", "y"})
    if (lower == yes) return true;
  for (const char* no : {"false", "no", "off", "n"})
    if (lower == no) return false;
  return std::nullopt;
}

}  // namespace parloc
