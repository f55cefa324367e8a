#include "common/filter/step_front_end.h"

#include <utility>

namespace parloc {

void StepFrontEnd::clear() {
  track_.clear();
  intake_.clear();
  continuous_.clear();
  is_prepared_ = false;
  odometry_.reset();
  elapsed_s_ = 0.0;
  jumped_ = false;
}

std::optional<OdometryReading> StepFrontEnd::prepare_odometry(double stamp_s, const Pose& odometry) {
  add_odometry(stamp_s, odometry);
  const double delay_s = config_.motion.odometry_delay_s;
  const Pose then = delay_s != 0.0 ? compose(odometry, track_.motion(stamp_s - delay_s, stamp_s)) : odometry;
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

bool StepFrontEnd::take(const Scan& scan, const SensorConfig& sensor, double resolution_m, BeamTable& beams) {
  return intake_.take(scan, intake_.lidar_of(scan), config_.scan, config_.lidars, sensor, track_,
                      resolution_m, beams);
}

BeamTable StepFrontEnd::beams_of(const Scan& scan, const SensorConfig& sensor, double resolution_m) const {
  const LidarSetup setup = lidar_setup(scan, config_.scan, find_lidar(config_.lidars, scan.sensor));
  const bool deskew = takes_time(scan, setup) && track_.knows_motion();
  BeamTable beams;
  BeamCounts counts;
  select_beams(scan, setup, deskew ? &track_ : nullptr, sensor, resolution_m, beams, counts);
  return beams;
}

std::vector<EndPoint> StepFrontEnd::end_points_of(const Scan& scan) const {
  const LidarSetup setup = lidar_setup(scan, config_.scan, find_lidar(config_.lidars, scan.sensor));
  const bool deskew = takes_time(scan, setup) && track_.knows_motion();
  return end_points(scan, setup, deskew ? &track_ : nullptr);
}

}  // namespace parloc
