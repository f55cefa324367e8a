// Quantiles of the normal distribution (Wichura 1988, AS 241, PPND16): relative error about 1e-16. The same
// bits everywhere.
#pragma once

namespace parloc {

/// z with P(Z <= z) = p, for p from 1e-10 to 1 - 1e-10.
double normal_quantile(double p);

}  // namespace parloc
