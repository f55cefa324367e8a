// Logarithm of the gamma function with the same bits everywhere, which std::lgamma has not.
#pragma once

namespace parloc {

/// log Gamma(x) for x > 0; relative error about 1e-15 (absolute below 1). Stirling's series from 10 on.
double log_gamma(double x);

/// log of the beta function, Gamma(a) Gamma(b) / Gamma(a + b), for a, b > 0.
inline double log_beta(double a, double b) {
  return log_gamma(a) + log_gamma(b) - log_gamma(a + b);
}

}  // namespace parloc
