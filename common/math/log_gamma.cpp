#include "common/math/log_gamma.h"

#include "common/math/portable64.h"

namespace parloc {

double log_gamma(double x) {
  constexpr double kHalfLogTwoPi = 0.91893853320467274178;
  double product = 1.0;  // Gamma(x) = Gamma(x + k) / (x (x + 1) ... (x + k - 1))
  for (; x < 10.0; x += 1.0) product *= x;
  const double inverse = 1.0 / x;
  const double series = inverse * polynomial64(inverse * inverse, -691.0 / 360360.0, 1.0 / 1188.0,
                                               -1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0, 1.0 / 12.0);
  return (x - 0.5) * portable_log64(x) - x + kHalfLogTwoPi + series - portable_log64(product);
}

}  // namespace parloc
