// A pose graph: poses, and what is known of one seen from another. Least squares finds the poses that fit all
// of it best (Lu and Milios 1997).
#pragma once

#include <cstddef>
#include <vector>

#include "common/flow/pose_algebra.h"
#include "common/math/pose.h"

namespace parloc {

struct PoseEdge {
  std::size_t from = 0, to = 0;
  Pose step;                         ///< Of pose `to`, seen from pose `from`.
  Matrix3 covariance = identity3();  ///< How sure of x, y [m] and heading [rad] that is.
  bool may_be_wrong = false;  ///< Weighs less the worse it fits (Cauchy): loops, which may be closed wrongly.
};

struct PoseGraphRules {
  double kernel = 3.0;       ///< Standard deviations at which an edge that may be wrong weighs half.
  int rounds = 20;           ///< At most.
  double least_step = 1e-4;  ///< It ends when no pose moves by more [m, rad].
};

/// How many standard deviations the poses are from what the edge says, squared.
double misfit_sq(const std::vector<Pose>& poses, const PoseEdge& edge);

/// Moves all poses but the first to where the edges want them: Gauss-Newton from where they are. Where
/// that has no answer, with poses that no edge holds, nothing moves. Deterministic, one thread.
void relax(std::vector<Pose>& poses, const std::vector<PoseEdge>& edges, const PoseGraphRules& rules = {});

}  // namespace parloc
