#include "common/filter/steps/step_front_end.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/filter/pose/gaussian.h"

namespace parloc {
namespace {

/// Odometry readings are followed so far beyond the last one.
constexpr double kAhead_s = 0.5;
/// So many scans in a row that are too old, each later than the one before: the clock was set back.
constexpr int kClockWasSet = 3;
/// Names are near with so many letters wrong.
constexpr std::size_t kNearName = 3;

}  // namespace

void StepFrontEnd::clear() {
  track_.clear();
  continuous_.clear();
  scaler_.clear();
  set_lidars_used({});
  is_prepared_ = false;
  odometry_.reset();
  elapsed_s_ = 0.0;
  jumped_ = false;
  why_no_odometry_.clear();
  told_not_finite_ = told_jump_ = false;
}

void StepFrontEnd::warn(bool& told, const std::string& text) const {
  if (!std::exchange(told, true) && config_.on_warning) config_.on_warning(text);
}

/// Of a LiDAR that is seen for the first time: whether one that is listed was meant.
void StepFrontEnd::warn_of_name(const std::string& name) const {
  if (!config_.on_warning || find_lidar(config_.lidars, name) != nullptr) return;
  std::vector<std::string> unseen;
  for (const LidarConfig& lidar : config_.lidars)
    if (std::none_of(used_.begin(), used_.end(), [&](const LidarUse& u) { return u.name == lidar.name; }))
      unseen.push_back(lidar.name);
  if (unseen.empty()) return;
  const std::string_view nearest = nearest_name(name, unseen);
  const bool is_near = edit_distance(std::string_view(name).substr(0, 100), nearest) <= kNearName;
  config_.on_warning(
      fmt::format("scan of LiDAR '{}', of which the settings say nothing: {} '{}', which has no scan yet",
                  printable(name), is_near ? "is it" : "they list", nearest));
}

const LidarStamps* StepFrontEnd::stamps_of(const Scan& scan) const {
  for (std::size_t k = 0; k < used_.size(); ++k)
    if (used_[k].name == scan.sensor) return &stamps_[k];
  return nullptr;
}

std::string StepFrontEnd::refusal(const Scan& scan) const {
  const LidarStamps* const s = config_.scan.check_stamps ? stamps_of(scan) : nullptr;
  if (s == nullptr || !s->newest_s) return {};
  if (scan.stamp_s == *s->last_s || scan.stamp_s == *s->newest_s)
    return "a scan of this LiDAR with this stamp was taken already";
  const double late_s = *s->newest_s - scan.stamp_s;
  if (late_s <= OdometryTrack::kRemembered_s) return {};
  const bool goes_on = s->refused_s && scan.stamp_s > *s->refused_s;
  if (goes_on && s->older + 1 >= kClockWasSet) return {};
  return fmt::format(
      "the scan is {:.1f} s older than this LiDAR's newest, and odometry is remembered for {:.0f} s", late_s,
      OdometryTrack::kRemembered_s);
}

std::string StepFrontEnd::refuse(const Scan& scan) {
  std::string why = refusal(scan);
  if (why.empty()) return why;
  LidarStamps& s = stamps_[lidar_of(scan)];
  if (*s.newest_s - scan.stamp_s <= OdometryTrack::kRemembered_s) return why;
  s.older = s.refused_s && scan.stamp_s > *s.refused_s ? s.older + 1 : 1;
  s.refused_s = scan.stamp_s;
  return why;
}

void StepFrontEnd::note_taken(const Scan& scan) {
  if (!config_.scan.check_stamps) return;
  LidarStamps& s = stamps_[lidar_of(scan)];
  const bool set_back = s.newest_s && *s.newest_s - scan.stamp_s > OdometryTrack::kRemembered_s;
  s.newest_s = set_back ? scan.stamp_s : std::max(s.newest_s.value_or(scan.stamp_s), scan.stamp_s);
  s.last_s = scan.stamp_s;
  s.older = 0;
  s.refused_s.reset();
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
  return take_in(stamp_s, then);
}

std::optional<OdometryReading> StepFrontEnd::prepare_odometry(double stamp_s) {
  const std::vector<StampedPose>& readings = track_.readings();
  is_prepared_ = true;
  prepared_.reset();
  if (readings.empty() || stamp_s < readings.front().stamp_s ||
      stamp_s > readings.back().stamp_s + kAhead_s) {
    why_no_odometry_ =
        readings.empty()
            ? "no odometry reading was added"
            : fmt::format("odometry readings are there from {:.3f} to {:.3f} s, the scan is of {:.3f} s",
                          readings.front().stamp_s, readings.back().stamp_s, stamp_s);
    return prepared_;
  }
  return take_in(stamp_s, track_.at(stamp_s));
}

/// The reading at the time of the scan.
std::optional<OdometryReading> StepFrontEnd::take_in(double stamp_s, const Pose& odometry) {
  prepared_ = continuous_.take(stamp_s, odometry);
  is_prepared_ = true;
  if (!prepared_) {
    why_no_odometry_ = "odometry not finite";
    warn(told_not_finite_, "odometry that is not finite: such steps are skipped and counted");
    return prepared_;
  }
  elapsed_s_ += prepared_->elapsed_s;
  jumped_ = jumped_ || prepared_->jumped;
  if (prepared_->jumped)
    warn(told_jump_, "odometry that jumps as no robot moves: such steps go on as before and are counted");
  return prepared_;
}

PoseEstimate StepFrontEnd::predict(const PoseEstimate& from, double from_s, double to_s) const {
  const std::vector<StampedPose>& readings = track_.readings();
  const double first_s = readings.empty() ? from_s : std::min(from_s, readings.front().stamp_s);
  const double last_s = readings.empty() ? from_s : std::max(from_s, readings.back().stamp_s);
  constexpr double kFar_s = OdometryTrack::kRemembered_s;
  if (!(to_s >= first_s - kFar_s && to_s <= last_s + kFar_s))
    throw Error(ErrorKind::input,
                fmt::format("predict: expected a stamp within {:.0f} s of {:.3f} to {:.3f} s, got {}", kFar_s,
                            first_s, last_s, to_s));
  const Pose motion = track_.motion(from_s, to_s);
  Movement movement;
  const double least_m = config_.motion.form == MotionForm::omni ? 0.0 : config_.motion.min_translation_m;
  movement.increment = odometry_increment({}, motion, least_m);
  movement.elapsed_s = std::fabs(to_s - from_s);
  movement.guessed = from_s != to_s && (!track_.knows_motion() || to_s > last_s + kAhead_s);
  return moved(from, motion, motion_step(movement, config_.motion));
}

std::optional<OdometryReading> StepFrontEnd::take_odometry(double stamp_s, const Pose& odometry) {
  if (!std::exchange(is_prepared_, false)) {
    prepare_odometry(stamp_s, odometry);
    is_prepared_ = false;
  }
  return prepared_;
}

bool StepFrontEnd::moved_enough(const std::optional<Pose>& before, const Pose& now) const {
  const double least_m = config_.update_min_d, least_rad = config_.update_min_a;
  if (!before || (least_m == 0.0 && least_rad == 0.0)) return true;
  return (least_m > 0.0 && distance_m(*before, now) >= least_m) ||
         (least_rad > 0.0 && turn_rad(*before, now) >= least_rad);
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
  warn_of_name(scan.sensor);
  used_.emplace_back().name = scan.sensor;
  directions_.emplace_back();
  stamps_.emplace_back();
  return used_.size() - 1;
}

void StepFrontEnd::set_lidars_used(std::vector<LidarUse> used) {
  used_ = std::move(used);
  directions_.assign(used_.size(), {});
  stamps_.assign(used_.size(), {});
}

/// Null for a scan that was taken in an instant, or is to be taken for one.
const OdometryTrack* StepFrontEnd::track_for(const Scan& scan, const LidarSetup& setup) const {
  return takes_time(scan, setup) && track_.knows_motion() ? &track_ : nullptr;
}

bool StepFrontEnd::take(const Scan& scan, const SensorConfig& sensor, double resolution_m, BeamTable& beams) {
  const std::size_t lidar = lidar_of(scan);
  LidarUse& use = used_[lidar];
  const LidarSetup setup = setup_of(scan);
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
  const LidarSetup setup = setup_of(scan);
  BeamTable beams;
  BeamCounts counts;
  select_beams(scan, setup, track_for(scan, setup), sensor, resolution_m, beams, counts);
  return beams;
}

std::vector<EndPoint> StepFrontEnd::end_points_of(const Scan& scan) const {
  const LidarSetup setup = setup_of(scan);
  return end_points(scan, setup, track_for(scan, setup));
}

BeamCounts StepFrontEnd::beam_counts() const {
  BeamCounts sum;
  for (const LidarUse& lidar : used_) sum += lidar.beams;
  return sum;
}

}  // namespace parloc
