// Odometry without the jumps of its own making: resets, glitches, readings of another robot.
#pragma once

#include <cstddef>
#include <optional>

#include "common/math/pose.h"
#include "common/model/motion_config.h"

namespace parloc {

/// One reading, as it is to be used.
struct OdometryReading {
  Pose pose;               ///< In a frame that never jumps: that of the first reading.
  double elapsed_s = 0.0;  ///< Since the reading before, at most 10 s; a guess where stamps stand still.
  bool jumped = false;     ///< The robot cannot have moved so; the motion is that of before.
};

/// What a ContinuousOdometry remembers.
struct OdometryMemory {
  Pose raw;              ///< Of the last reading, as it came.
  Pose pose;             ///< And as it was given out.
  double stamp_s = 0.0;  ///< Likewise.
  Pose step;             ///< The last motion that was none of a jump, in the robot's frame, ...
  double step_s = 0.0;   ///< ... and how long it took; 0: there was none.
  double since_s = 0.0;  ///< Time since then.
  double pace_s = 0.0;   ///< From reading to reading, in the mean of the last twenty or so, ...
  int paced = 0;         ///< ... that is of so many, if they are fewer.
  int stood_still = 0;   ///< Readings in a row whose stamp was not later than the one before.
  bool rebased = false;  ///< There was a jump, so that `pose` is no longer `raw`.
};

/// Adds up the odometry's steps, and leaves out those that no robot makes: faster than the limits allow, or
/// than the speed before and the acceleration since. There the motion of before goes on. Stamps of some logs
/// come in bursts: no step is judged over less than the mean time between readings. So what follows need
/// know nothing of jumps. Deterministic on every machine; readings of any size, finite or not, leave it
/// sound.
class ContinuousOdometry {
 public:
  /// So long is a step taken for where stamps stand still.
  static constexpr double kGuess_s = 0.1;

  /// `limits` outlives this.
  explicit ContinuousOdometry(const MotionConfig& limits) : limits_(limits) {}

  /// The next reading; nothing if it is not finite.
  std::optional<OdometryReading> take(double stamp_s, const Pose& raw);
  /// Forgets the readings and the counts.
  void clear();

  std::size_t jumps() const { return jumps_; }      ///< Since the start.
  std::size_t invalid() const { return invalid_; }  ///< Readings that were not finite.
  /// Readings whose stamp was not later than the one before.
  std::size_t stalled() const { return stalled_; }

  /// What it remembers; nothing before the first reading.
  const std::optional<OdometryMemory>& memory() const { return last_; }
  /// Goes on from what another one remembered.
  void restore(const std::optional<OdometryMemory>& memory) { last_ = memory; }

 private:
  bool possible(const Pose& step, double stamps_s, bool clock_runs) const;

  const MotionConfig& limits_;
  std::optional<OdometryMemory> last_;
  std::size_t jumps_ = 0, invalid_ = 0, stalled_ = 0;
};

}  // namespace parloc
