#include "common/model/odometry_scaler.h"

namespace parloc {

bool OdometryScaler::active() const {
  const bool side = motion_.form == MotionForm::omni && motion_.odometry_scale_side != 1.0;
  return motion_.odometry_scale_drive != 1.0 || motion_.odometry_scale_turn != 1.0 || side;
}

Pose OdometryScaler::take(const Pose& raw) {
  if (!active() || !is_finite(raw)) return raw;
  Pose pose = raw;
  if (last_) {
    const ArcMotion step = arc_motion(relative(raw, last_->raw));
    const double side =
        motion_.form == MotionForm::omni ? motion_.odometry_scale_side : motion_.odometry_scale_drive;
    pose = compose(last_->pose, arc_end({motion_.odometry_scale_drive * step.ahead_m, side * step.side_m,
                                         motion_.odometry_scale_turn * step.turn_rad}));
    if (!is_finite(pose)) pose = raw;  // beyond what numbers hold: it starts again
  }
  last_ = Memory{raw, pose};
  return pose;
}

}  // namespace parloc
