#include "common/filter/step_front_end.h"

#include <cmath>

namespace parloc {

void StepFrontEnd::clear() {
  track_.clear();
  intake_.clear();
  odometry_.reset();
  jumps_ = invalid_ = 0;
}

bool StepFrontEnd::accept(const Pose& odometry) {
  if (is_finite(odometry)) return true;
  ++invalid_;
  return false;
}

bool StepFrontEnd::moved_enough(const std::optional<Pose>& before, const Pose& now) const {
  return !before || distance_m(*before, now) >= config_.update_min_d ||
         turn_rad(*before, now) >= config_.update_min_a;
}

Movement StepFrontEnd::move_to(const Pose& now) {
  Movement movement;
  if (odometry_) movement.increment = odometry_increment(*odometry_, now, config_.motion.min_translation_m);
  odometry_ = now;
  const double length_m = std::fabs(movement.increment.trans_m), most_m = config_.motion.max_jump_m;
  if (length_m > most_m) {
    ++jumps_;
    movement.inflation = length_m / most_m;
  }
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
