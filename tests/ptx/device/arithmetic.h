// What PTX's instructions compute, as the PTX ISA says it, edge cases included: shifts by more than the
// width, division by zero, NaN. Only instructions whose result is defined bit by bit are here.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace ptx {

template <class T>
inline constexpr unsigned kBits = sizeof(T) * 8;
template <class T>
using Unsigned = std::make_unsigned_t<T>;

/// The one NaN that float32 arithmetic gives, whatever went in. Of float64 the payload of the operand is
/// kept.
inline float canonical(float x) {
  return x == x ? x : std::bit_cast<float>(0x7fffffffu);
}
inline double canonical(double x) {
  return x;
}

// ---- integers: they wrap ----------------------------------------------------------------------------------
template <class T>
T add(T a, T b) {
  if constexpr (std::is_floating_point_v<T>)
    return canonical(a + b);
  else
    return static_cast<T>(std::uint64_t(a) + std::uint64_t(b));
}
template <class T>
T subtract(T a, T b) {
  if constexpr (std::is_floating_point_v<T>)
    return canonical(a - b);
  else
    return static_cast<T>(std::uint64_t(a) - std::uint64_t(b));
}
template <class T>
T multiply(T a, T b) {  // the low half
  if constexpr (std::is_floating_point_v<T>)
    return canonical(a * b);
  else
    return static_cast<T>(std::uint64_t(a) * std::uint64_t(b));
}
template <class T>
T multiply_high(T a, T b) {
  __extension__ using Wide = std::conditional_t<std::is_signed_v<T>, __int128, unsigned __int128>;
  return static_cast<T>((Wide{a} * Wide{b}) >> kBits<T>);
}
template <class Wide, class T>
Wide multiply_wide(T a, T b) {
  return multiply(Wide{a}, Wide{b});
}
/// By zero: all bits set; of the most negative number by -1: itself.
template <class T>
T divide(T a, T b) {
  if constexpr (std::is_floating_point_v<T>) {
    return canonical(a / b);
  } else {
    if (b == 0) return static_cast<T>(~T{0});
    if constexpr (std::is_signed_v<T>)
      if (b == -1) return subtract(T{0}, a);
    return static_cast<T>(a / b);
  }
}
template <class T>
T remainder(T a, T b) {
  if (b == 0) return a;
  if constexpr (std::is_signed_v<T>)
    if (b == -1) return 0;
  return static_cast<T>(a % b);
}
template <class T>
T negate(T a) {
  if constexpr (std::is_floating_point_v<T>)
    return -a;
  else
    return subtract(T{0}, a);
}
template <class T>
T absolute(T a) {
  if constexpr (std::is_floating_point_v<T>)
    return std::fabs(a);
  else
    return a < 0 ? negate(a) : a;
}

// ---- floating point ---------------------------------------------------------------------------------------
template <class T>
T fused(T a, T b, T c) {
  return canonical(std::fma(a, b, c));
}
template <class T>
T square_root(T a) {
  return canonical(std::sqrt(a));
}
template <class T>
T reciprocal(T a) {
  return divide(T{1}, a);
}
/// A number wins over NaN, and +0 is larger than -0.
template <class T>
T maximum(T a, T b) {
  if constexpr (std::is_floating_point_v<T>) {
    if (a != a) return canonical(b);
    if (b != b) return a;
    if (a == b) return std::signbit(a) ? b : a;
  }
  return a > b ? a : b;
}
template <class T>
T minimum(T a, T b) {
  if constexpr (std::is_floating_point_v<T>) {
    if (a != a) return canonical(b);
    if (b != b) return a;
    if (a == b) return std::signbit(a) ? a : b;
  }
  return a < b ? a : b;
}
template <class T>
T copy_sign(T sign, T magnitude) {
  return std::copysign(magnitude, sign);
}
template <class T>
bool unordered(T a, T b) {
  return a != a || b != b;
}

// ---- bits -------------------------------------------------------------------------------------------------
template <class T>
T shift_left(T a, std::uint32_t n) {
  return n >= kBits<T> ? T{0} : static_cast<T>(std::uint64_t(a) << n);
}
template <class T>
T shift_right(T a, std::uint32_t n) {
  if (n >= kBits<T>) return static_cast<T>(a < 0 ? ~T{0} : T{0});
  return static_cast<T>(a >> n);
}
/// The upper or lower word of high:low, shifted.
inline std::uint32_t funnel_left(std::uint32_t low, std::uint32_t high, std::uint32_t n) {
  return static_cast<std::uint32_t>(((std::uint64_t{high} << 32 | low) << n) >> 32);
}
inline std::uint32_t funnel_right(std::uint32_t low, std::uint32_t high, std::uint32_t n) {
  return static_cast<std::uint32_t>((std::uint64_t{high} << 32 | low) >> n);
}
template <class T>
std::uint32_t leading_zeros(T a) {
  return static_cast<std::uint32_t>(std::countl_zero(Unsigned<T>(a)));
}
template <class T>
std::uint32_t population(T a) {
  return static_cast<std::uint32_t>(std::popcount(Unsigned<T>(a)));
}
/// The place of the highest bit that is not the sign; all bits set where there is none.
template <class T>
std::uint32_t find_leading(T a) {
  const Unsigned<T> bits = a < 0 ? static_cast<Unsigned<T>>(~a) : static_cast<Unsigned<T>>(a);
  return kBits<T> - 1 - leading_zeros(bits);
}
/// The shift that would bring that bit to the top.
template <class T>
std::uint32_t find_leading_shift(T a) {
  const std::uint32_t place = find_leading(a);
  return place == ~0u ? place : kBits<T> - 1 - place;
}
template <class T>
T reverse(T a) {
  T r = 0;
  for (unsigned i = 0; i < kBits<T>; ++i) r |= ((a >> i) & T{1}) << (kBits<T> - 1 - i);
  return r;
}
template <class T>
T ones(std::uint32_t length) {
  return length >= kBits<T> ? ~T{0} : static_cast<T>((T{1} << length) - 1);
}
/// `length` bits of a put into b at `place`; only the low eight bits of both numbers count.
template <class T>
T insert(T a, T b, std::uint32_t place, std::uint32_t length) {
  place &= 0xff, length &= 0xff;
  const T mask = shift_left(ones<T>(length), place);
  return (b & ~mask) | (shift_left(a, place) & mask);
}
/// `length` bits of a from `place`, extended with the sign of the last of them.
template <class T>
T extract(T a, std::uint32_t place, std::uint32_t length) {
  place &= 0xff, length &= 0xff;
  if (length == 0) return 0;
  const auto mask = ones<Unsigned<T>>(length);
  const auto bits = static_cast<Unsigned<T>>(shift_right(Unsigned<T>(a), place) & mask);
  const std::uint32_t last = place + length - 1 < kBits<T> - 1 ? place + length - 1 : kBits<T> - 1;
  const bool negative = std::is_signed_v<T> && (a >> last & 1) != 0;
  return static_cast<T>(negative ? bits | static_cast<Unsigned<T>>(~mask) : bits);
}
/// Four bytes chosen from the eight of b:a; the top bit of a choice repeats the byte's sign.
inline std::uint32_t permute(std::uint32_t a, std::uint32_t b, std::uint32_t choice) {
  const std::uint64_t bytes = std::uint64_t{b} << 32 | a;
  std::uint32_t r = 0;
  for (unsigned i = 0; i < 4; ++i) {
    const std::uint32_t c = choice >> 4 * i & 15;
    auto byte = static_cast<std::uint8_t>(bytes >> 8 * (c & 7));
    if (c & 8) byte = byte & 0x80 ? 0xff : 0;
    r |= std::uint32_t{byte} << 8 * i;
  }
  return r;
}
/// Any function of three bits, by its table of truth.
inline std::uint32_t any_of_three(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t table) {
  std::uint32_t r = 0;
  for (unsigned i = 0; i < 8; ++i)
    if (table >> i & 1) r |= (i & 4 ? a : ~a) & (i & 2 ? b : ~b) & (i & 1 ? c : ~c);
  return r;
}

// ---- conversions ------------------------------------------------------------------------------------------
/// To the nearest integer that the type has. NaN: 0, and the top bit alone where 64 bits are concerned.
template <class To, class From>
To saturate(From x) {
  using Limits = std::numeric_limits<To>;
  if (x != x)
    return sizeof(From) == 8 || sizeof(To) == 8 ? static_cast<To>(std::uint64_t{1} << (kBits<To> - 1))
                                                : To{0};
  // Both bounds are powers of two, or zero: exact in either type.
  const From end = std::ldexp(From{1}, static_cast<int>(kBits<To>) - (std::is_signed_v<To> ? 1 : 0));
  if (x >= end) return Limits::max();
  if (x < (std::is_signed_v<To> ? -end : From{0})) return Limits::min();
  return static_cast<To>(x);
}
/// Integer to integer, held within the target's range.
template <class To, class From>
To clamp_to(From x) {
  __extension__ using Wide = __int128;
  const Wide low = std::numeric_limits<To>::min(), high = std::numeric_limits<To>::max();
  return static_cast<To>(Wide{x} < low ? low : Wide{x} > high ? high : Wide{x});
}
/// To a float type, rounded to the nearest.
template <class To, class From>
To to_float(From x) {
  return canonical(static_cast<To>(x));
}

}  // namespace ptx
