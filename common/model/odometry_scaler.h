// Odometry with the scales of its wheels put right.
#pragma once

#include <optional>

#include "common/math/pose.h"
#include "common/model/motion_config.h"

namespace parloc {

/// Multiplies the motion from reading to reading by motion.odometry_scale_drive, _turn and (form omni) _side;
/// each step is taken for an arc, so that it hardly matters how many readings a way has, or whether one comes
/// again. The first reading stays. With scales of 1 readings are given back bit by bit. Deterministic on
/// every machine.
class OdometryScaler {
 public:
  /// Of the last reading, as it came and as it was given out.
  struct Memory {
    Pose raw, pose;
  };

  /// `motion` outlives this.
  explicit OdometryScaler(const MotionConfig& motion) : motion_(motion) {}

  /// One that is not finite is given back as it is, and forgotten.
  Pose take(const Pose& raw);
  void clear() { last_.reset(); }
  /// Whether any scale is another than 1.
  bool active() const;

  const std::optional<Memory>& memory() const { return last_; }
  void restore(const std::optional<Memory>& memory) { last_ = memory; }

 private:
  const MotionConfig& motion_;
  std::optional<Memory> last_;
};

}  // namespace parloc
