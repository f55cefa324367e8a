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

// The moments of weighted points in parts, each of which lanes may share: every sum has its own order, point
// after point.

/// A choice, not an index: registers of a GPU have none.
PARLOC_HD double component(const Vector3& d, int axis) {
  return axis == 0 ? d[0] : axis == 1 ? d[1] : d[2];
}
PARLOC_HD double largest_of(const double* value, int count) {
  double most = value[0];
  for (int k = 1; k < count; ++k) most = value[k] > most ? value[k] : most;
  return most;
}
/// Weighted sums of the offsets along axes `first` to `end` - 1, added to sum[0] and on; axis 3: of the
/// weights alone.
template <class OffsetOf>
PARLOC_HD void add_offsets(const double* weight, int count, const OffsetOf& offset, int first, int end,
                           double* sum) {
  for (int k = 0; k < count; ++k) {
    const Vector3 d = offset(k);
    for (int a = first; a < end; ++a) sum[a - first] += a < 3 ? weight[k] * component(d, a) : weight[k];
  }
}
/// Elements `first` to `end` - 1 of the covariance about `shift`, of weights whose sum is `sum`, added to
/// spread[0] and on.
template <class OffsetOf>
PARLOC_HD void add_spread(const double* weight, int count, double sum, const Vector3& shift,
                          const OffsetOf& offset, int first, int end, double* spread) {
  for (int k = 0; k < count; ++k) {
    const Vector3 d = plus(offset(k), -1.0, shift);
    const double share = weight[k] / sum;
    for (int e = first; e < end; ++e)
      spread[e - first] += share * (component(d, e / 3) * component(d, e % 3));
  }
}

/// Mean offset, of sums by add_offsets(0 to 4).
PARLOC_HD Vector3 shift_of(const double* sum) {
  Vector3 shift;
  for (int a = 0; a < 3; ++a) shift[a] = sum[a] / sum[3];
  return shift;
}

/// Mean and covariance of `count` points that weigh exp(log_weight), which become the weights: averages of
/// offsets, so that headings near half a turn do no harm.
template <class OffsetOf>
PARLOC_HD ProposalMoments proposal_moments(double* log_weight, int count, const OffsetOf& offset) {
  ProposalMoments m;
  const double most = largest_of(log_weight, count);
  for (int k = 0; k < count; ++k) log_weight[k] = portable_exp64(log_weight[k] - most);
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  add_offsets(log_weight, count, offset, 0, 4, sum);
  m.shift = shift_of(sum);
  add_spread(log_weight, count, sum[3], m.shift, offset, 0, 9, m.covariance.m);
  m.log_eta = most + portable_log64(sum[3]);
  return m;
}

/// log N(d; 0, q), of the factor of q.
PARLOC_HD double log_density(const Cholesky3& q, const Vector3& d) {
  constexpr double kLog2Pi3 = 5.513631199228036;  // 3 log(2 pi)
  return -0.5 * (gaussian_exponent(q, d) + kLog2Pi3);
}

}  // namespace parloc
