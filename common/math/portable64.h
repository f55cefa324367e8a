// float64 functions with the same bits everywhere, for what the host computes per step and the device once
// per estimate. fdlibm's polynomials; sin/cos reduced by fma, good to 1 ulp for |x| < 1e5; atan2, exp and log
// under 1 ulp.
#pragma once

#include <cstdint>
#include <cstring>

#include "common/math/host_device.h"

namespace parloc {

constexpr double kPi = 3.14159265358979323846;

PARLOC_HD double fused64(double a, double b, double c) {
  return __builtin_fma(a, b, c);
}

/// first x^n + ... + last, from the inside out: each step fused, and with a rounding of its product.
PARLOC_HD double fused_polynomial64(double x, double first, auto... others) {
  double sum = first;
  ((sum = fused64(sum, x, others)), ...);
  return sum;
}
PARLOC_HD double polynomial64(double x, double first, auto... others) {
  double sum = first;
  ((sum = sum * x + others), ...);
  return sum;
}

PARLOC_HD std::uint64_t bits_of64(double x) {
  std::uint64_t b;
  std::memcpy(&b, &x, sizeof b);
  return b;
}
PARLOC_HD double double_of(std::uint64_t bits) {
  double x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

/// exp(x); 0 below -700, exp(700) above 700.
PARLOC_HD double portable_exp64(double x) {
  if (!(x > -700.0)) return 0.0;
  if (x > 700.0) x = 700.0;
  const double k = __builtin_rint(x * 1.44269504088896338700e+00);
  const double high = x - k * 6.93147180369123816490e-01;
  const double low = k * 1.90821492927058770002e-10;
  const double r = high - low;
  const double t = r * r;
  const double p =
      polynomial64(t, 4.13813679705723846039e-08, -1.65339022054652515390e-06, 6.61375632143793436117e-05,
                   -2.77777777770155933842e-03, 1.66666666666666019037e-01);
  const double c = r - t * p;
  const double y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
  return y * double_of(static_cast<std::uint64_t>(static_cast<std::int64_t>(k) + 1023) << 52);
}

/// Natural logarithm of a positive normal number.
PARLOC_HD double portable_log64(double x) {
  // x = 2^k m with m in [sqrt(1/2), sqrt(2))
  const std::uint64_t bits = bits_of64(x) + (0x3ff0000000000000u - 0x3fe6a09e00000000u);
  const double k = static_cast<double>(static_cast<std::int64_t>(bits >> 52) - 1023);
  const double f = double_of((bits & 0x000fffffffffffffu) + 0x3fe6a09e00000000u) - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  const double r =
      z * polynomial64(z, 1.479819860511658591e-01, 1.531383769920937332e-01, 1.818357216161805012e-01,
                       2.222219843214978396e-01, 2.857142874366239149e-01, 3.999999999940941908e-01,
                       6.666666666666735130e-01);
  const double half = 0.5 * f * f;
  return k * 6.93147180369123816490e-01 - ((half - (s * (half + r) + k * 1.90821492927058770002e-10)) - f);
}

struct SinCos64 {
  double sin;
  double cos;
};

PARLOC_HD SinCos64 portable_sincos64(double x) {
  const double k = __builtin_rint(x * 0.63661977236758134308);
  double r = fused64(-k, 1.57079632679489655800e+00, x);
  r = fused64(-k, 6.12323399573676603587e-17, r);
  const double z = r * r;
  const double ps = fused_polynomial64(z, 1.58969099521155010221e-10, -2.50507602534068634195e-08,
                                       2.75573137070700676789e-06, -1.98412698298579493134e-04,
                                       8.33333333332248946124e-03, -1.66666666666666324348e-01);
  const double s = fused64(ps * z, r, r);
  const double pc = fused_polynomial64(z, -1.13596475577881948265e-11, 2.08757232129817482790e-09,
                                       -2.75573143513906633035e-07, 2.48015872894767294178e-05,
                                       -1.38888888888741095749e-03, 4.16666666666666019037e-02);
  const double c = fused64(pc * z, z, fused64(-0.5, z, 1.0));
  const long long q = static_cast<long long>(k);
  const double s0 = (q & 1) != 0 ? c : s;
  const double c0 = (q & 1) != 0 ? s : c;
  return {(q & 2) != 0 ? -s0 : s0, ((q + 1) & 2) != 0 ? -c0 : c0};
}

/// atan of t in [0, 1].
PARLOC_HD double portable_atan_unit64(double t) {
  // Reduce by atan(1/2) or atan(1), as fdlibm does, so that the series sees |t| <= 7/16.
  double offset = 0.0;
  if (t > 0.6875) {
    t = (t - 1.0) / (t + 1.0);
    offset = 7.85398163397448278999e-01;
  } else if (t > 0.4375) {
    t = (2.0 * t - 1.0) / (2.0 + t);
    offset = 4.63647609000806093515e-01;
  }
  const double z = t * t;
  const double p =
      fused_polynomial64(z, 1.62858201153657823623e-02, -3.65315727442169155270e-02,
                         4.97687799461593236017e-02, -5.83357013379057348645e-02, 6.66107313738753120669e-02,
                         -7.69187620504482999495e-02, 9.09088713343650656196e-02, -1.11111104054623557880e-01,
                         1.42857142725034663711e-01, -1.99999999998764832476e-01, 3.33333333333329318027e-01);
  return offset + fused64(-(p * z), t, t);
}

/// Angle of (x, y) in [-pi, pi]; (0, 0) gives 0.
PARLOC_HD double portable_atan2_64(double y, double x) {
  const double ax = __builtin_fabs(x);
  const double ay = __builtin_fabs(y);
  const double hi = ax > ay ? ax : ay;
  const double lo = ax > ay ? ay : ax;
  if (hi == 0.0) return 0.0;
  double a = portable_atan_unit64(lo / hi);
  if (ay > ax) a = 1.57079632679489661923 - a;
  if (x < 0.0) a = kPi - a;
  return y < 0.0 ? -a : a;
}

/// Wraps an angle into [-pi, pi) (SPEC 0.1).
PARLOC_HD double wrap64(double a) {
  double r = a - 2.0 * kPi * __builtin_floor((a + kPi) / (2.0 * kPi));
  if (r >= kPi) r -= 2.0 * kPi;
  if (r < -kPi) r += 2.0 * kPi;
  return r;
}

}  // namespace parloc
