// A drive by its odometry, with the wheels' scales put right, at any time.
#pragma once

#include <cstddef>
#include <vector>

#include "common/math/pose.h"
#include "common/model/trajectory.h"

namespace parloc {

/// What the odometry's motion is multiplied by to be the true one.
struct OdometryScales {
  double drive = 1.0;            ///< Along the robot's heading.
  double side = 1.0;             ///< To its side: of robots with omnidirectional wheels.
  double turn = 1.0;             ///< Of its turns.
  double drift_rad_per_m = 0.0;  ///< It turns by so much besides for each true metre ahead: unequal wheels.
};

/// All readings of a log, in one time that never goes back. Deterministic on every machine.
class OdometryPath {
 public:
  /// `readings` in the order of their stamps; of equal ones the last counts.
  explicit OdometryPath(const Trajectory& readings);

  /// The path is made anew from the readings' steps; each is an arc of the robot's motion.
  void set_scales(const OdometryScales& scales);
  /// Between readings on the arc; before the first and after the last it stands still.
  Pose at(double time_s) const;
  /// Heading by the readings themselves, without scales and never wrapped.
  double raw_heading_rad(double time_s) const;

  bool empty() const { return times_s_.empty(); }
  double first_s() const { return times_s_.front(); }
  double last_s() const { return times_s_.back(); }
  double period_s() const { return period_s_; }  ///< Median time from reading to reading.
  double ahead_m() const { return ahead_m_; }    ///< All that it drove along its heading, by the readings,
  double sideways_m() const { return side_m_; }  ///< ... and to its side.
  double turned_rad() const { return turned_rad_; }

 private:
  /// A step as velocities over one unit of time: how far along the heading, to its side, and the turn.
  struct Step {
    double ahead_m, side_m, turn_rad;
  };
  std::size_t before(double time_s) const;

  std::vector<double> times_s_;
  std::vector<Step> steps_;  ///< From each reading to the next.
  std::vector<double> headings_rad_;
  std::vector<Pose> poses_;  ///< With the scales.
  std::vector<Pose> moves_;  ///< Likewise, from each reading to the next.
  double period_s_ = 0.0, ahead_m_ = 0.0, side_m_ = 0.0, turned_rad_ = 0.0;
};

}  // namespace parloc
