// Text and numbers inside a web page.
#pragma once

#include <cmath>
#include <string>
#include <string_view>

namespace parloc::tools {

/// Text as it may stand between tags and inside quoted attributes: & < > " ' are escaped, control characters
/// (other than tab and newline) and bytes that are not UTF-8 become U+FFFD.
std::string escape_html(std::string_view text);

/// A number for a reader: at most `decimals` decimals without trailing zeros, an exponent beyond 1e7, a dash
/// for what is not finite.
std::string number_text(double value, int decimals);

/// A number that may be drawn. Excludes NaN, infinity and what would overflow when scaled.
inline bool drawable(double value) {
  return std::abs(value) < 1e30;
}

}  // namespace parloc::tools
