// float32 functions that give the same bits on every CPU and GPU (SPEC 0.6): only + - * /, sqrt, explicit fma
// and exact conversions, in a fixed order. Branches are selects, so that loops over them vectorise. Stated
// errors: exp 1.02 ulp on [-87, 0], log 0.83 ulp over normals, sin/cos 9.3e-8 absolute for |x| <= 12.6,
// erfc 5e-6 relative for 0 <= x <= 9, log of the upper tail 4e-7 + 1.5e-7 of its size.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "common/math/host_device.h"

namespace parloc {

PARLOC_HD float fused(float a, float b, float c) {
  return __builtin_fmaf(a, b, c);
}
/// The same without a fused operation: the product is exact in double, and the sum rounded to odd, so that
/// rounding it once more to float cannot go astray.
PARLOC_HD float fused_by_double(float a, float b, float c) {
  const double product = static_cast<double>(a) * static_cast<double>(b), addend = static_cast<double>(c);
  const double sum = product + addend;
  const double back = sum - product;
  const double error = (product - (sum - back)) + (addend - back);  // exact: what rounding the sum has lost
  std::int64_t bits;
  std::memcpy(&bits, &sum, sizeof bits);
  const bool inexact = error > 0.0 || error < 0.0, outwards = (error > 0.0) == (sum > 0.0);
  bits += inexact && (bits & 1) == 0 ? (outwards ? 1 : -1) : 0;
  double odd;
  std::memcpy(&odd, &bits, sizeof odd);
  return static_cast<float>(odd);
}
/// fused() for scalar loops that may run on a CPU without it, where the library takes ten times as long.
PARLOC_HD float fused_anywhere(float a, float b, float c) {
#if defined(__x86_64__) && !defined(__FMA__) && !defined(__CUDA_ARCH__)
  return fused_by_double(a, b, c);
#else
  return fused(a, b, c);
#endif
}
/// a b + c, of which the last bit does not matter, the quickest way.
PARLOC_HD float nearly_fused(float a, float b, float c) {
#if defined(__x86_64__) && !defined(__FMA__) && !defined(__CUDA_ARCH__)
  return a * b + c;
#else
  return fused(a, b, c);
#endif
}
/// first x^n + ... + last, from the inside out, each step fused.
PARLOC_HD float polynomial(float x, float first, auto... others) {
  float sum = first;
  ((sum = fused(sum, x, others)), ...);
  return sum;
}
PARLOC_HD float portable_sqrt(float x) {
  return __builtin_sqrtf(x);
}
PARLOC_HD float round_even(float x) {
  return __builtin_rintf(x);
}
PARLOC_HD float floor_of(float x) {
  return __builtin_floorf(x);
}
PARLOC_HD float min_of(float a, float b) {
  return a < b ? a : b;
}
PARLOC_HD float max_of(float a, float b) {
  return a > b ? a : b;
}

/// Place of the lowest bit that is set; there must be one.
PARLOC_HD std::int32_t lowest_bit(std::uint32_t x) {
#ifdef __CUDA_ARCH__
  return __ffs(static_cast<int>(x)) - 1;
#else
  return __builtin_ctz(x);
#endif
}

PARLOC_HD std::uint32_t bits_of(float x) {
  std::uint32_t b;
  std::memcpy(&b, &x, sizeof b);
  return b;
}
PARLOC_HD float float_of(std::uint32_t bits) {
  float x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

/// The nearest integer to x, |x| <= 2^22, ties to even: what the sum leaves in the low bits. Quicker than a
/// conversion that must answer for all floats.
PARLOC_HD std::int32_t whole_of(float x) {
  return static_cast<std::int32_t>(bits_of(x + 12582912.0f)) - 0x4B400000;
}

/// The nearest integer to x, |x| < 2^31, ties to even. Without rint, which loops for CPUs without SSE4.1
/// would have to call.
PARLOC_HD std::int32_t nearest_of(float x) {
#ifdef __CUDA_ARCH__
  return __float2int_rn(x);
#else
  const float whole = x < 0.0f ? -8388608.0f : 8388608.0f;  // 2^23: from there on floats are whole
  const float rounded = (x + whole) - whole;
  return static_cast<std::int32_t>(__builtin_fabsf(x) < 8388608.0f ? rounded : x);
#endif
}

/// exp(x); 0 below -87, +inf above 88.
PARLOC_HD float portable_exp(float x) {
  const float xc = min_of(max_of(x, -87.0f), 88.0f);  // NaN takes -87 here and is the caller's to reject
  const float n = round_even(xc * 1.44269504f);
  float r = fused(n, -0.693359375f, xc);
  r = fused(n, 2.12194440e-4f, r);
  const float p = polynomial(r, 1.9875691500e-4f, 1.3981999507e-3f, 8.3334519073e-3f, 4.1665795894e-2f,
                             1.6666665459e-1f, 5.0000001201e-1f);
  const float scale = float_of(static_cast<std::uint32_t>(static_cast<std::int32_t>(n) + 127) << 23);
  const float y = (fused(p, r * r, r) + 1.0f) * scale;
  const float low = x < -87.0f ? 0.0f : y;
  return x > 88.0f ? float_of(0x7f800000u) : low;
}

/// log(x) of a positive normal number.
PARLOC_HD float portable_log(float x) {
  const std::uint32_t b = bits_of(x);
  const float m0 = float_of((b & 0x007fffffu) | 0x3f000000u);  // mantissa in [0.5, 1)
  const float e0 = static_cast<float>(static_cast<std::int32_t>(b >> 23) - 126);
  const bool low = m0 < 0.707106781f;
  const float e = low ? e0 - 1.0f : e0;
  const float m = (low ? m0 + m0 : m0) - 1.0f;
  const float z = m * m;
  const float p =
      polynomial(m, 7.0376836292e-2f, -1.1514610310e-1f, 1.1676998740e-1f, -1.2420140846e-1f,
                 1.4249322787e-1f, -1.6668057665e-1f, 2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f);
  float y = p * m * z;
  y = fused(e, -2.12194440e-4f, y);
  y = fused(-0.5f, z, y);
  return fused(e, 0.693359375f, m + y);
}

/// first x^n + ... + last as above, each step rounded twice.
PARLOC_HD float plain_polynomial(float x, float first, auto... others) {
  float sum = first;
  ((sum = sum * x + others), ...);
  return sum;
}

/// exp(x) for x <= 60; not below 2^-126, its value from -86.6 on.
PARLOC_HD float quick_exp(float x) {
  const float y = max_of(x * 1.44269504f, -125.0f);
  const float shifted = y + 12582912.0f;  // the nearest whole number is in its low bits
  const float r = y - (shifted - 12582912.0f);
  const float p =
      plain_polynomial(r, 1.3264725e-3f, 9.6715132e-3f, 5.5507338e-2f, 2.4022242e-1f, 6.9314698e-1f, 1.0f);
  return float_of(bits_of(p) + (bits_of(shifted) << 23));  // times 2 to that number
}

/// log(x) of a positive normal number.
PARLOC_HD float quick_log(float x) {
  constexpr std::uint32_t kRootOfHalf = 0x3f3504f3u;
  const std::int32_t e = static_cast<std::int32_t>(bits_of(x) - kRootOfHalf) >> 23;
  const float f = float_of(bits_of(x) - (static_cast<std::uint32_t>(e) << 23)) - 1.0f;
  const float q =
      plain_polynomial(f, 1.1708034e-1f, -1.8496914e-1f, 2.0493811e-1f, -2.4936867e-1f, 3.3317432e-1f, -0.5f);
  return (q * f) * f + f + static_cast<float>(e) * 0.693147181f;
}

struct SinCos {
  float sin;
  float cos;
};

/// Sine and cosine of |x| <= 64.
PARLOC_HD SinCos portable_sincos(float x) {
  const float k = round_even(x * 0.636619772f);
  float r = fused(k, -1.5703125f, x);
  r = fused(k, -4.837512969970703125e-4f, r);
  r = fused(k, -7.54978995489188216e-8f, r);
  const float z = r * r;
  const float ps = polynomial(z, -1.9515295891e-4f, 8.3321608736e-3f, -1.6666654611e-1f);
  const float s = fused(ps * z, r, r);
  const float pc = polynomial(z, 2.443315711809948e-5f, -1.388731625493765e-3f, 4.166664568298827e-2f);
  const float c = fused(pc * z, z, fused(-0.5f, z, 1.0f));
  const std::int32_t q = static_cast<std::int32_t>(k);
  const bool swap = (q & 1) != 0;
  const float s0 = swap ? c : s;
  const float c0 = swap ? s : c;
  return {(q & 2) != 0 ? -s0 : s0, ((q + 1) & 2) != 0 ? -c0 : c0};
}

/// log(erfc(x) exp(x^2) / t) of t = 1 / (1 + x / 2), x >= 0: a Chebyshev fit (Numerical Recipes, erfcc).
PARLOC_HD float erfc_exponent(float t, auto of_coefficients) {
  return of_coefficients(t, 0.17087277f, -0.82215223f, 1.48851587f, -1.13520398f, 0.27886807f, -0.18628806f,
                         0.09678418f, 0.37409196f, 1.00002368f, -1.26551223f);
}
PARLOC_HD float erfc_exponent(float t) {
  return erfc_exponent(t, [](float x, auto... c) { return polynomial(x, c...); });
}

/// Complementary error function of x >= 0; 0 beyond 9.
PARLOC_HD float portable_erfc(float x) {
  const float xc = min_of(x, 9.0f);
  const float t = 1.0f / fused(0.5f, xc, 1.0f);
  return t * portable_exp(fused(-xc, xc, erfc_exponent(t)));
}
PARLOC_HD float quick_erfc(float x) {
  const float xc = min_of(x, 9.0f);
  const float t = 1.0f / (0.5f * xc + 1.0f);
  const float exponent = erfc_exponent(t, [](float at, auto... c) { return plain_polynomial(at, c...); });
  return t * quick_exp(exponent - xc * xc);
}

/// log(1 - Phi(x)) of x >= 0, Phi the standard normal distribution. By way of erfcx, so that it has no end:
/// the tail itself underflows from x = 14 on.
PARLOC_HD float portable_log_upper_tail(float x) {
  const float t = 1.0f / fused(0.353553391f, x, 1.0f);
  return portable_log(0.5f * t) + fused(-0.5f * x, x, erfc_exponent(t));
}

/// Wraps an angle of a few turns into [-pi, pi).
PARLOC_HD float wrap(float a) {
  const float k = floor_of(fused(a, 0.159154943f, 0.5f));
  float r = fused(-k, 6.28318548f, a);
  r = fused(-k, -1.74845553e-7f, r);
  const bool outside = r >= 3.14159274f || r < -3.14159274f;
  return outside ? -3.14159274f : r;
}

}  // namespace parloc
