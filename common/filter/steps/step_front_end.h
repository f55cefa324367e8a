// What all filters do before a step: is the odometry a number, has the robot moved enough, how did it move,
// which beams count, and what became of the others, LiDAR by LiDAR.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/filter/pose/covariance.h"
#include "common/filter/steps/step_config.h"
#include "common/model/beams.h"
#include "common/model/continuous_odometry.h"
#include "common/model/motion.h"
#include "common/model/odometry_scaler.h"
#include "common/model/odometry_track.h"

namespace parloc {

/// Of one LiDAR, for scan.check_stamps.
struct LidarStamps {
  std::optional<double> last_s, newest_s, refused_s;  ///< Taken; taken; too old, the last of `older`.
  int older = 0;                                      ///< Scans in a row that were refused for that.
};

/// Follows one drive. Nothing that it is given throws but a scan whose arrays do not fit together.
class StepFrontEnd {
 public:
  /// `config` outlives this.
  explicit StepFrontEnd(const StepConfig& config)
      : config_(config), scaler_(config.motion), track_(config.motion), continuous_(config.motion) {}
  void clear();

  /// Throws Error{input} for a scan that makes no sense (lidar_setup). To be called before anything is made
  /// of it.
  void check(const Scan& scan) const { (void)setup_of(scan); }
  /// Why a scan is not to be taken, by scan.check_stamps; empty if it is.
  std::string refusal(const Scan& scan) const;
  /// The same, and counts those that are refused. Once per step.
  std::string refuse(const Scan& scan);
  /// Remembers the stamp of a scan that is taken.
  void note_taken(const Scan& scan);
  /// A reading between steps, in any order. One that is not finite is left out.
  void add_odometry(double stamp_s, const Pose& odometry) {
    track_.add(stamp_s - config_.motion.odometry_delay_s, scaler_.take(odometry));
  }
  /// The reading of a step, as it is to be used: at the time of the scan, and without the odometry's own
  /// jumps (ContinuousOdometry). Nothing if it is not finite: the step is to be skipped.
  std::optional<OdometryReading> take_odometry(double stamp_s, const Pose& odometry);
  /// The same for whoever wants to know before the step, which then takes this.
  std::optional<OdometryReading> prepare_odometry(double stamp_s, const Pose& odometry);
  /// By the readings that were added. Nothing if they do not reach to `stamp_s`: their last two seconds, and
  /// half a second on with the motion that they end with.
  std::optional<OdometryReading> prepare_odometry(double stamp_s);
  /// Why the last of these gave nothing.
  const std::string& why_no_odometry() const { return why_no_odometry_; }
  /// The last reading that was given out, and its stamp; none before the first.
  const std::optional<OdometryMemory>& last_reading() const { return continuous_.memory(); }
  /// A pose of one time at another, by the readings between and the noise of their motion. Throws
  /// Error{input} for a time more than two seconds from all that is remembered.
  PoseEstimate predict(const PoseEstimate& from, double from_s, double to_s) const;
  /// Whether a scan counts: the robot has moved update_min_d or turned update_min_a since `before`, where
  /// that is above 0; both 0: it does. SPEC 6.4.
  bool moved_enough(const std::optional<Pose>& before, const Pose& now) const;
  /// From the last step's odometry to `now`, which becomes the last; the first step is none. What a short
  /// step says to the side is kept for the next (odometry_increment). How long it took, and whether it is a
  /// guess, is known of what take_odometry() gave since the last.
  Movement move_to(const Pose& now);
  /// Of the last step; empty before the first.
  const std::optional<Pose>& odometry() const { return odometry_; }
  /// The next step starts from there.
  void set_odometry(const std::optional<Pose>& odometry) { odometry_ = odometry; }

  /// Place of the scan's LiDAR among those seen so far; new ones are added.
  std::size_t lidar_of(const Scan& scan);
  /// Fills `beams` with those that count, seen from the base at the scan's stamp; whether there are
  /// scan.min_beams of them. Allocates only for the largest scan so far. Throws Error{input}.
  bool take(const Scan& scan, const SensorConfig& sensor, double resolution_m, BeamTable& beams);
  /// The same without counting anything.
  BeamTable beams_of(const Scan& scan, const SensorConfig& sensor, double resolution_m) const;
  std::vector<EndPoint> end_points_of(const Scan& scan) const;

  /// Whether the odometry has jumped since the last step.
  bool jumped() const { return jumped_; }
  void set_jumped(bool jumped) { jumped_ = jumped; }

  /// By LiDAR, in the order in which they came.
  const std::vector<LidarUse>& lidars_used() const { return used_; }
  /// Goes on counting from there.
  void set_lidars_used(std::vector<LidarUse> used);
  /// Of the same LiDARs; of use with scan.check_stamps alone.
  const std::vector<LidarStamps>& stamps() const { return stamps_; }
  /// Goes on from there. As many as lidars_used().
  void set_stamps(std::vector<LidarStamps> stamps) { stamps_ = std::move(stamps); }
  BeamCounts beam_counts() const;  ///< Summed over all LiDARs.
  OdometryTrack& track() { return track_; }
  const OdometryTrack& track() const { return track_; }
  OdometryScaler& scaler() { return scaler_; }
  const OdometryScaler& scaler() const { return scaler_; }
  ContinuousOdometry& continuous() { return continuous_; }
  const ContinuousOdometry& continuous() const { return continuous_; }

 private:
  LidarSetup setup_of(const Scan& scan) const {
    return lidar_setup(scan, config_.scan, find_lidar(config_.lidars, scan.sensor));
  }
  const LidarStamps* stamps_of(const Scan& scan) const;
  std::optional<OdometryReading> take_in(double stamp_s, const Pose& odometry);
  void warn(bool& told, const std::string& text) const;
  void warn_of_name(const std::string& name) const;
  const OdometryTrack* track_for(const Scan& scan, const LidarSetup& setup) const;

  const StepConfig& config_;
  OdometryScaler scaler_;
  OdometryTrack track_;
  std::vector<LidarUse> used_;
  std::vector<BeamDirections> directions_;  ///< Of each LiDAR.
  std::vector<LidarStamps> stamps_;         ///< Likewise.
  ContinuousOdometry continuous_;
  std::optional<OdometryReading> prepared_;
  bool is_prepared_ = false;
  std::optional<Pose> odometry_;
  double elapsed_s_ = 0.0;  ///< Since odometry_.
  bool jumped_ = false;     ///< Likewise.
  std::string why_no_odometry_;
  bool told_not_finite_ = false, told_jump_ = false;
};

}  // namespace parloc
