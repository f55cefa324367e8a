// Terms and finishing of the weighted mean and covariance (SPEC 4): both of all particles and of the heaviest
// cluster.
#pragma once

#include "common/filter/stages.h"
#include "common/math/block_sum.h"
#include "common/math/portable64.h"

namespace parloc {

constexpr int kMeanSums = 8;         // x, y, sin, cos of all; the same of the cluster
constexpr int kCovarianceSums = 12;  // xx, xy, xt, yy, yt, tt of all; the same of the cluster

/// First pass: weighted sums of x, y, sin(theta), cos(theta). `in_cluster` is 1 or 0.
PARLOC_HD SumVector<kMeanSums> mean_terms(float x, float y, float theta, std::uint64_t weight,
                                          bool in_cluster) {
  const double w = static_cast<double>(weight);
  const double c = in_cluster ? w : 0.0;
  const SinCos a = portable_sincos(theta);
  const double sin = static_cast<double>(a.sin);
  const double cos = static_cast<double>(a.cos);
  return {{w * x, w * y, w * sin, w * cos, c * x, c * y, c * sin, c * cos}};
}

/// Second pass: weighted products about the two means, heading difference wrapped.
PARLOC_HD SumVector<kCovarianceSums> covariance_terms(float x, float y, float theta, std::uint64_t weight,
                                                      bool in_cluster, const Moments& all,
                                                      const Moments& cluster) {
  const double w = static_cast<double>(weight);
  const double c = in_cluster ? w : 0.0;
  const double ax = x - all.x, ay = y - all.y, at = wrap64(theta - all.theta);
  const double bx = x - cluster.x, by = y - cluster.y, bt = wrap64(theta - cluster.theta);
  return {{w * (ax * ax), w * (ax * ay), w * (ax * at), w * (ay * ay), w * (ay * at), w * (at * at),
           c * (bx * bx), c * (bx * by), c * (bx * bt), c * (by * by), c * (by * bt), c * (bt * bt)}};
}

PARLOC_HD void finish_mean(Moments& m, const double* sums, double weight, double total) {
  m.weight = weight / total;
  m.x = sums[0] / weight;
  m.y = sums[1] / weight;
  const double s = sums[2] / weight, c = sums[3] / weight;
  m.theta = wrap64(portable_atan2_64(s, c));
  m.resultant = __builtin_sqrt(s * s + c * c);
}

PARLOC_HD void finish_covariance(Moments& m, const double* sums, double weight) {
  m.xx = sums[0] / weight;
  m.xy = sums[1] / weight;
  m.xt = sums[2] / weight;
  m.yy = sums[3] / weight;
  m.yt = sums[4] / weight;
  m.tt = sums[5] / weight;
}

}  // namespace parloc
