#include "tools/report/text/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace parloc::tools {

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  if (value == 0.0) return "0";
  const auto decimals = [&](double v) {
    return std::clamp(digits - 1 - static_cast<int>(std::floor(std::log10(std::fabs(v)))), 0, 12);
  };
  // Rounding may carry into another digit: 0.0999 is 0.10 with two.
  const double rounded = std::stod(fmt::format("{:.{}e}", value, digits - 1));
  return fmt::format("{:.{}f}", rounded, decimals(rounded));
}

std::string fixed_text(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

std::string percent_text(double share) {
  return std::isfinite(share) ? fmt::format("{:.1f} %", 100.0 * share) : "-";
}

std::string seconds_text(double seconds) {
  return seconds >= 0.01 ? fmt::format("{:.4f}", seconds) : significant(seconds, 3);
}

std::string milliseconds_text(double seconds) {
  return significant(1e3 * seconds, 3);
}

std::string short_number(double value) {
  for (const auto& [size, letter] : {std::pair{1e9, "G"}, {1e6, "M"}, {1e3, "k"}}) {
    if (value >= size) return fmt::format("{} {}", significant(value / size, 3), letter);
  }
  return significant(value, 3);
}

std::string size_text(std::int64_t particles, int beams) {
  return fmt::format("{}x{}", particles, beams);
}

std::string grouped(std::int64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3 && text[at - 4] != '-'; at -= 3) text.insert(at - 3, ",");
  return text;
}

}  // namespace parloc::tools
