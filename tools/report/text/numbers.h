// Numbers for people: few digits, plain notation.
#pragma once

#include <cstdint>
#include <string>

namespace parloc::tools {

/// `digits` significant digits, no exponent: 0.00123, 45.6, 789, 12300. A dash for what is not finite.
std::string significant(double value, int digits);

/// A dash for what is not finite.
std::string fixed_text(double value, int decimals);
std::string percent_text(double share);  ///< "12.3 %".

/// Seconds with 0.1 ms or 3 digits, whichever is finer: "0.7679", "0.00123".
std::string seconds_text(double seconds);
std::string milliseconds_text(double seconds);  ///< 3 digits.
/// "68.9 M", "1.49 G": per second, or a number of particles.
std::string short_number(double value);
/// "4000x200".
std::string size_text(std::int64_t particles, int beams);
/// Whole numbers in groups: "16,777,216".
std::string grouped(std::int64_t number);

}  // namespace parloc::tools
