#include "common/filter/step_front_end.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace parloc {

void StepFrontEnd::clear() {
  track_.clear();
  set_lidars_used({});
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
  for (const LidarUse& lidar : used_) {
    const BeamCounts& c = lidar.beams;
    sum.total += c.total;
    sum.considered += c.considered;
    sum.used += c.used;
    sum.misses += c.misses;
    sum.nan += c.nan;
    sum.infinite += c.infinite;
    sum.negative += c.negative;
    sum.zero += c.zero;
    sum.below_min += c.below_min;
  }
  return sum;
}

}  // namespace parloc
