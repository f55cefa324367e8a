// The robot's motion around a scan, from odometry readings.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "common/math/pose.h"
#include "common/model/motion_config.h"
#include "common/model/trajectory.h"

namespace parloc {

/// The last two seconds of odometry. Between two readings the robot drives an arc at constant speed; before
/// the first and after the last reading it goes on with the twist that it had there. Deterministic on every
/// machine; does not allocate once it has grown.
class OdometryTrack {
 public:
  static constexpr double kRemembered_s = 2.0;
  /// A twist is taken over at least this time: stamps jitter.
  static constexpr double kShortestTwist_s = 0.02;

  /// A step between readings that is longer than motion.max_jump_m, and than the robot is fast, is a jump of
  /// the odometry: what was before it is forgotten.
  explicit OdometryTrack(const MotionConfig& motion)
      : longest_step_m_(motion.max_jump_m), max_speed_mps_(motion.max_speed_mps) {}

  /// In any order; of equal stamps the last counts. What is not finite is ignored. A stamp more than two
  /// seconds before the newest is another clock: it starts anew.
  void add(double stamp_s, const Pose& odometry);
  void clear() { readings_.clear(); }
  /// What it remembers, and taking it up again.
  const std::vector<StampedPose>& readings() const { return readings_; }
  void set_readings(std::vector<StampedPose> readings) { readings_ = std::move(readings); }

  /// Whether there are two readings far enough apart. Without, the robot is taken to stand still.
  bool knows_motion() const;
  /// Where the base is at a time, in the frame of the readings, of which there is one at least; at the time
  /// of one exactly that.
  Pose at(double stamp_s) const;
  /// Where the base is at one time, seen from where it is at another. A twist that goes on beyond the
  /// readings is taken over at least `twist_s`.
  Pose motion(double from_s, double to_s, double twist_s = kShortestTwist_s) const;

 private:
  Pose at(double stamp_s, double twist_s) const;

  double longest_step_m_, max_speed_mps_;
  std::vector<StampedPose> readings_;  ///< By ascending stamp, no two equal.
};

}  // namespace parloc
