// Numbers of the command line: decimal, the whole word, no silent wrap-around.
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <limits>
#include <string>
#include <system_error>
#include <vector>

#include "common/error.h"
#include "common/search/search_config.h"

namespace parloc::tools {

/// A whole number from `low` to `high`. Throws Error{usage} naming `option`.
template <class Integer>
Integer parse_whole_number(const char* option, const std::string& text,
                           Integer low = std::numeric_limits<Integer>::min(),
                           Integer high = std::numeric_limits<Integer>::max()) {
  Integer value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size() || value < low || value > high) {
    throw Error(ErrorKind::usage,
                fmt::format("{}: expected a whole number from {} to {}, got '{}'", option, low, high, text));
  }
  return value;
}

/// The same; `otherwise` if the text is empty.
inline std::uint64_t whole_within(const char* option, const std::string& text, std::uint64_t low,
                                  std::uint64_t high, std::uint64_t otherwise) {
  return text.empty() ? otherwise : parse_whole_number(option, text, low, high);
}

/// A number from `low` to `high`. Throws Error{usage} naming `option`.
inline double parse_number(const char* option, const std::string& text, double low, double high) {
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high)) {
    throw Error(ErrorKind::usage,
                fmt::format("{}: expected a number from {:g} to {:g}, got '{}'", option, low, high, text));
  }
  return value;
}

/// What stands between commas; an empty text has one part, which is empty.
std::vector<std::string> split_at_commas(const std::string& text);

/// Where the robot may be, as --near and --heading say: `near` is "x,y,radius" [m], `heading`
/// "angle,tolerance" [rad]; empty is not known. Throws Error{usage} for anything else.
SearchPrior parse_search_prior(const std::string& near, const std::string& heading);

}  // namespace parloc::tools
