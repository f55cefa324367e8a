#include "common/filter/step_front_end.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace parloc {

void StepFrontEnd::clear() {
  track_.clear();
  continuous_.clear();
  scaler_.clear();
  set_lidars_used({});
  is_prepared_ = false;
  odometry_.reset();
  elapsed_s_ = 0.0;
  jumped_ = false;
}

std::optional<OdometryReading> StepFrontEnd::prepare_odometry(double stamp_s, const Pose& odometry) {
  const double delay_s = config_.motion.odometry_delay_s;
  const Pose scaled = scaler_.take(odometry);
  track_.add(stamp_s - delay_s, scaled);
  // Over as long as the odometry is late: stamps of some logs come in bursts, between which there is no
  // speed.
  const double twist_s = std::max(OdometryTrack::kShortestTwist_s, std::abs(delay_s));
  const Pose then =
      delay_s != 0.0 ? compose(scaled, track_.motion(stamp_s - delay_s, stamp_s, twist_s)) : scaled;
  prepared_ = continuous_.take(stamp_s, then);
  if (prepared_) {
    elapsed_s_ += prepared_->elapsed_s;
    jumped_ = jumped_ || prepared_->jumped;
  }
  is_prepared_ = true;
  return prepared_;
}

std::optional<OdometryReading> StepFrontEnd::take_odometry(double stamp_s, const Pose& odometry) {
  if (!std::exchange(is_prepared_, false)) {
    prepare_odometry(stamp_s, odometry);
    is_prepared_ = false;
  }
  return prepared_;
}

bool StepFrontEnd::moved_enough(const std::optional<Pose>& before, const Pose& now) const {
  return !before || distance_m(*before, now) >= config_.update_min_d ||
         turn_rad(*before, now) >= config_.update_min_a;
}

Movement StepFrontEnd::move_to(const Pose& now) {
  Movement movement;
  movement.elapsed_s = std::exchange(elapsed_s_, 0.0);
  movement.guessed = std::exchange(jumped_, false);
  if (!odometry_) {
    odometry_ = now;
    return movement;
  }
  const MotionConfig& c = config_.motion;
  constexpr double kNothing_m = 1e-12;  // SPEC 1.5: below it there is no bearing
  const double least_m = c.form == MotionForm::omni ? kNothing_m : c.min_translation_m;
  movement.increment = odometry_increment(*odometry_, now, least_m);
  // Below least_m, what was to the side is left for the next step; else all of it has been used.
  Pose used = now;
  if (distance_m(*odometry_, now) < least_m) used = moved(*odometry_, movement.increment);
  odometry_ = {used.x_m, used.y_m, now.theta_rad};
  return movement;
}

std::size_t StepFrontEnd::lidar_of(const Scan& scan) {
  for (std::size_t k = 0; k < used_.size(); ++k)
    if (used_[k].name == scan.sensor) return k;
  used_.emplace_back().name = scan.sensor;
  directions_.emplace_back();
  return used_.size() - 1;
}

void StepFrontEnd::set_lidars_used(std::vector<LidarUse> used) {
  used_ = std::move(used);
  directions_.assign(used_.size(), {});
}

/// Null for a scan that was taken in an instant, or is to be taken for one.
const OdometryTrack* StepFrontEnd::track_for(const Scan& scan, const LidarSetup& setup) const {
  return takes_time(scan, setup) && track_.knows_motion() ? &track_ : nullptr;
}

bool StepFrontEnd::take(const Scan& scan, const SensorConfig& sensor, double resolution_m, BeamTable& beams) {
  const std::size_t lidar = lidar_of(scan);
  LidarUse& use = used_[lidar];
  const LidarSetup setup = lidar_setup(scan, config_.scan, find_lidar(config_.lidars, scan.sensor));
  const OdometryTrack* track = track_for(scan, setup);
  select_beams(scan, setup, track, sensor, resolution_m, beams, use.beams, &directions_[lidar]);
  const bool enough = beams.count >= static_cast<std::size_t>(config_.scan.min_beams);

  const std::size_t size = scan.ranges_m.size();
  const bool moving = takes_time(scan, setup);
  use.max_beams = setup.max_beams;
  use.smallest = use.scans == 0 ? size : std::min(use.smallest, size);
  use.largest = std::max(use.largest, size);
  ++use.scans;
  use.moving += moving ? 1 : 0;
  use.unknown_motion += moving && track == nullptr ? 1 : 0;
  use.too_few += enough ? 0 : 1;
  use.beams.used += enough ? beams.count : 0;
  return enough;
}

BeamTable StepFrontEnd::beams_of(const Scan& scan, const SensorConfig& sensor, double resolution_m) const {
  const LidarSetup setup = lidar_setup(scan, config_.scan, find_lidar(config_.lidars, scan.sensor));
  BeamTable beams;
  BeamCounts counts;
  select_beams(scan, setup, track_for(scan, setup), sensor, resolution_m, beams, counts);
  return beams;
}

std::vector<EndPoint> StepFrontEnd::end_points_of(const Scan& scan) const {
  const LidarSetup setup = lidar_setup(scan, config_.scan, find_lidar(config_.lidars, scan.sensor));
  return end_points(scan, setup, track_for(scan, setup));
}

BeamCounts StepFrontEnd::beam_counts() const {
  BeamCounts sum;
  for (const LidarUse& lidar : used_) sum += lidar.beams;
  return sum;
}

}  // namespace parloc
