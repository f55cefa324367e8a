// The fields of one line of text, separated by blanks: fast, locale-free, and with a clear word when one is
// wrong.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "common/error.h"

namespace parloc {

/// Why a line makes no sense: "expected ..., found ...". Readers catch it and add file and line.
struct BrokenLine {
  std::string why;
};

/// The whole text as a number, whatever the locale. A leading '+', which from_chars does not know, is
/// allowed.
template <class Number>
std::errc parse_number(std::string_view text, Number& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return end == text.data() + text.size() ? status : std::errc::invalid_argument;
}

/// What older Windows runtimes print for a number that is not finite: "1.#INF", "-1.#IND", "1.#QNAN", with
/// any zeros behind. False for any other text.
inline bool windows_number(std::string_view text, double& value) {
  const bool negative = !text.empty() && text.front() == '-';
  if (negative || (!text.empty() && text.front() == '+')) text.remove_prefix(1);
  while (!text.empty() && text.back() == '0') text.remove_suffix(1);
  if (text == "1.#INF") {
    value = negative ? -HUGE_VAL : HUGE_VAL;
  } else if (text == "1.#IND" || text == "1.#QNAN" || text == "1.#SNAN") {
    value = std::nan("");
  } else {
    return false;
  }
  return true;
}

class Fields {
 public:
  explicit Fields(std::string_view line) : rest_(line) {}

  bool empty() {
    skip_blanks();
    return rest_.empty();
  }

  /// The next field; empty at the end of the line.
  std::string_view text() {
    skip_blanks();
    const std::string_view field = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(field.size());
    return field;
  }

  /// The next field as a number; "nan", "inf" and what windows_number() knows are numbers. Throws BrokenLine
  /// naming `what` was expected.
  template <class Number>
  Number number(const char* what) {
    skip_blanks();
    const char* const end = rest_.data() + rest_.size();
    const char* start = rest_.data();
    if (rest_.size() > 1 && *start == '+' && rest_[1] != '-') ++start;  // from_chars takes no plus sign
    Number value{};
    const auto [stop, error] = std::from_chars(start, end, value);
    if (error != std::errc{} || (stop != end && *stop != ' ' && *stop != '\t')) {
      if constexpr (std::is_floating_point_v<Number>) {
        const Fields before = *this;
        if (double special = 0.0; windows_number(text(), special)) return static_cast<Number>(special);
        *this = before;
      }
      fail(what);
    }
    rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()));
    return value;
  }

  /// A finite number of at most `limit` in size.
  double bounded(const char* what, double limit) {
    const std::string_view before = rest_;
    const double value = number<double>(what);
    if (!(std::fabs(value) <= limit)) {
      rest_ = before;
      fail(what);
    }
    return value;
  }

  [[noreturn]] void fail(const char* what) {
    const std::string_view found = text();
    throw BrokenLine{std::string("expected ") + what + ", found " +
                     (found.empty() ? std::string("the end of the line") : "'" + printable(found) + "'")};
  }

  std::size_t bytes_left() const { return rest_.size(); }

 private:
  void skip_blanks() {
    std::size_t i = 0;
    while (i < rest_.size() && (rest_[i] == ' ' || rest_[i] == '\t')) ++i;
    rest_.remove_prefix(i);
  }

  std::string_view rest_;
};

}  // namespace parloc
