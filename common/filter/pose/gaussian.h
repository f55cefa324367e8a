// The arithmetic of Gaussians over poses: drawing from one, and where odometry leads it.
#pragma once

#include "common/filter/pose/covariance.h"
#include "common/math/pose.h"
#include "common/model/motion.h"

namespace parloc {

/// Lower triangle L with L L^T = covariance, by rows.
struct CovarianceRoot {
  double xx = 0.0, yx = 0.0, yy = 0.0, tx = 0.0, ty = 0.0, tt = 0.0;
};
/// Of a diagonal one exactly the standard deviations. A direction without error is allowed. Throws
/// Error{input} unless it is finite, symmetric and positive semidefinite, but for rounding.
CovarianceRoot root_of(const Covariance& covariance);

/// Where a pose is after `motion`, which is seen from it, and how sure it is then: what is unsure of its
/// heading becomes unsure of its place, and the noise of `step`, which is that motion's, comes on top (SPEC
/// 1).
PoseEstimate moved(const PoseEstimate& from, const Pose& motion, const MotionStep& step);

}  // namespace parloc
