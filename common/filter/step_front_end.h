// What all filters do before a step: is the odometry a number, has the robot moved enough, how did it move,
// which beams count.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/filter/scan_intake.h"
#include "common/filter/step_config.h"
#include "common/model/continuous_odometry.h"
#include "common/model/motion.h"
#include "common/model/odometry_track.h"

namespace parloc {

/// Follows one drive. Nothing that it is given throws but a scan whose arrays do not fit together.
class StepFrontEnd {
 public:
  /// `config` outlives this.
  explicit StepFrontEnd(const StepConfig& config)
      : config_(config), track_(config.motion), continuous_(config.motion) {}
  void clear();

  /// A reading between steps, in any order. One that is not finite is left out.
  void add_odometry(double stamp_s, const Pose& odometry) {
    track_.add(stamp_s - config_.motion.odometry_delay_s, odometry);
  }
  /// The reading of a step, as it is to be used: at the time of the scan, and without the odometry's own
  /// jumps (ContinuousOdometry). Nothing if it is not finite: the step is to be skipped.
  std::optional<OdometryReading> take_odometry(double stamp_s, const Pose& odometry);
  /// The same for whoever wants to know before the step, which then takes this.
  std::optional<OdometryReading> prepare_odometry(double stamp_s, const Pose& odometry);
  /// Whether a scan counts: the robot has moved update_min_d or turned update_min_a since `before`. SPEC 6.4.
  bool moved_enough(const std::optional<Pose>& before, const Pose& now) const;
  /// From the last step's odometry to `now`, which becomes the last; the first step is none. What a short
  /// step says to the side is kept for the next (odometry_increment). How long it took, and whether it is a
  /// guess, is known of what take_odometry() gave since the last.
  Movement move_to(const Pose& now);
  /// Of the last step; empty before the first.
  const std::optional<Pose>& odometry() const { return odometry_; }
  /// The next step starts from there.
  void set_odometry(const std::optional<Pose>& odometry) { odometry_ = odometry; }

  std::size_t lidar_of(const Scan& scan) { return intake_.lidar_of(scan); }
  /// Fills `beams`; whether there are scan.min_beams of them. Throws Error{input}.
  bool take(const Scan& scan, const SensorConfig& sensor, double resolution_m, BeamTable& beams);
  /// The same without counting anything.
  BeamTable beams_of(const Scan& scan, const SensorConfig& sensor, double resolution_m) const;
  std::vector<EndPoint> end_points_of(const Scan& scan) const;

  ScanIntake& intake() { return intake_; }
  const ScanIntake& intake() const { return intake_; }
  OdometryTrack& track() { return track_; }
  const OdometryTrack& track() const { return track_; }
  ContinuousOdometry& continuous() { return continuous_; }
  const ContinuousOdometry& continuous() const { return continuous_; }

 private:
  const StepConfig& config_;
  OdometryTrack track_;
  ScanIntake intake_;
  ContinuousOdometry continuous_;
  std::optional<OdometryReading> prepared_;
  bool is_prepared_ = false;
  std::optional<Pose> odometry_;
  double elapsed_s_ = 0.0;  // since odometry_
  bool jumped_ = false;     // likewise
};

}  // namespace parloc
