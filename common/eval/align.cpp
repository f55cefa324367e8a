#include "common/eval/align.h"

#include <cmath>
#include <vector>

#include "common/eval/metrics.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

struct Pair {
  Pose estimate, truth;
};

std::vector<Pair> pairs_of(const Trajectory& estimate, const Trajectory& truth) {
  std::vector<double> stamps;
  for (const StampedPose& p : estimate) stamps.push_back(p.stamp_s);
  const std::vector<std::optional<Pose>> at = truth_at(truth, stamps);
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < at.size(); ++k)
    if (at[k]) pairs.push_back({estimate[k].pose, *at[k]});
  return pairs;
}

}  // namespace

std::optional<Pose> best_alignment(const Trajectory& estimate, const Trajectory& truth) {
  const std::vector<Pair> pairs = pairs_of(estimate, truth);
  if (pairs.empty()) return std::nullopt;
  const double count = static_cast<double>(pairs.size());
  double ex = 0.0, ey = 0.0, tx = 0.0, ty = 0.0;
  for (const Pair& p : pairs) {
    ex += p.estimate.x_m / count, ey += p.estimate.y_m / count;
    tx += p.truth.x_m / count, ty += p.truth.y_m / count;
  }
  double along = 0.0, across = 0.0;  // sums of scalar and cross products of truth and estimate
  for (const Pair& p : pairs) {
    const double ax = p.truth.x_m - tx, ay = p.truth.y_m - ty;
    const double bx = p.estimate.x_m - ex, by = p.estimate.y_m - ey;
    along += ax * bx + ay * by, across += ax * by - ay * bx;
  }
  if (std::hypot(along, across) < 1e-9) return std::nullopt;  // the robot stood still
  const Pose turn{0.0, 0.0, portable_atan2_64(across, along)};
  const Pose centre = compose(turn, {tx, ty, 0.0});
  return Pose{ex - centre.x_m, ey - centre.y_m, turn.theta_rad};
}

Trajectory transformed(const Pose& T, Trajectory track) {
  for (StampedPose& p : track) p.pose = compose(T, p.pose);
  return track;
}

}  // namespace parloc
