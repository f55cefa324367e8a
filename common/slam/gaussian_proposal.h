// The improved proposal (Grisetti, Stachniss and Burgard 2007, eq. 9 to 12; SPEC 9.3): the product of the
// scan's likelihood and the motion model, sampled on a grid around the best fit and taken for a Gaussian.
#pragma once

#include "common/flow/pose_gaussian.h"
#include "common/slam/matching/match_beam.h"

namespace parloc {

constexpr int kBoxNodes = 5;  ///< Along each axis.
constexpr int kBoxPoints = kBoxNodes * kBoxNodes * kBoxNodes;

struct ProposalBox {
  double half_xy = 0, half_theta = 0;  ///< [m, rad]
  PARLOC_HD double volume() const { return 8.0 * half_xy * half_xy * half_theta; }
  /// From the best fit; nodes at the centres of a 5 x 5 x 5 partition, so that volume / points belongs to
  /// each.
  PARLOC_HD Vector3 offset(int k) const {
    const int node[3] = {k % kBoxNodes, k / kBoxNodes % kBoxNodes, k / (kBoxNodes * kBoxNodes)};
    Vector3 d;
    for (int a = 0; a < 3; ++a)
      d[a] = (a < 2 ? half_xy : half_theta) * static_cast<double>(2 * node[a] + 1 - kBoxNodes) / kBoxNodes;
    return d;
  }
};

struct ProposalMoments {
  double log_eta = 0;  ///< Of the sum over the points.
  Vector3 shift;       ///< Mean of the offsets.
  Matrix3 covariance;
};

/// Mean and covariance of `count` points that weigh exp(log_weight): averages of offsets, so that headings
/// near half a turn do no harm.
template <class OffsetOf>
PARLOC_HD ProposalMoments proposal_moments(const double* log_weight, int count, const OffsetOf& offset) {
  ProposalMoments m;
  double most = log_weight[0];
  for (int k = 1; k < count; ++k) most = log_weight[k] > most ? log_weight[k] : most;
  double sum = 0.0;
  Vector3 mean;
  for (int k = 0; k < count; ++k) {
    const double w = portable_exp64(log_weight[k] - most);
    sum += w;
    mean = plus(mean, w, offset(k));
  }
  for (int a = 0; a < 3; ++a) m.shift[a] = mean[a] / sum;
  Matrix3 spread;
  for (int k = 0; k < count; ++k) {
    const double w = portable_exp64(log_weight[k] - most);
    spread = plus_outer(spread, w / sum, plus(offset(k), -1.0, m.shift));
  }
  m.covariance = spread;
  m.log_eta = most + portable_log64(sum);
  return m;
}

/// log N(d; 0, q), of the factor of q.
PARLOC_HD double log_density(const Cholesky3& q, const Vector3& d) {
  constexpr double kLog2Pi3 = 5.513631199228036;  // 3 log(2 pi)
  return -0.5 * (gaussian_exponent(q, d) + kLog2Pi3);
}

}  // namespace parloc
