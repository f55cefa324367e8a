#include "common/calibrate/odometry_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/quantile.h"

namespace parloc {

namespace {

/// Way is measured over steps so long: over shorter ones noise looks like a way to the side.
constexpr double kLong_m = 0.1;
/// Nor does a step that turns so far tell to which side it went.
constexpr double kTurned_rad = 0.15;

}  // namespace

OdometryPath::OdometryPath(const Trajectory& readings) {
  const auto is_last_of_stamp = [&](std::size_t k) {
    return k + 1 == readings.size() || readings[k + 1].stamp_s > readings[k].stamp_s;
  };
  Pose last, long_before;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    if (!is_last_of_stamp(k)) continue;
    const Pose& now = readings[k].pose;
    if (!times_s_.empty()) {
      const ArcMotion arc = arc_motion(relative(now, last));
      steps_.push_back({arc.ahead_m, arc.side_m, arc.turn_rad});
      headings_rad_.push_back(headings_rad_.back() + arc.turn_rad);
      turned_rad_ += std::fabs(arc.turn_rad);
    } else {
      headings_rad_.push_back(now.theta_rad);
      long_before = now;
    }
    const bool turned = turn_rad(long_before, now) >= kTurned_rad;
    if (turned) ahead_m_ += distance_m(long_before, now);
    if (distance_m(long_before, now) >= kLong_m && !turned) {
      const ArcMotion arc = arc_motion(relative(now, long_before));
      ahead_m_ += std::fabs(arc.ahead_m), side_m_ += std::fabs(arc.side_m);
    }
    if (turned || distance_m(long_before, now) >= kLong_m) long_before = now;
    times_s_.push_back(readings[k].stamp_s);
    last = now;
  }
  std::vector<double> periods_s;
  for (std::size_t k = 1; k < times_s_.size(); ++k) periods_s.push_back(times_s_[k] - times_s_[k - 1]);
  if (!periods_s.empty()) period_s_ = median(ascending(std::move(periods_s)));
  set_scales({});
}

void OdometryPath::set_scales(const OdometryScales& s) {
  poses_.assign(times_s_.empty() ? 0 : 1, Pose{});
  moves_.clear();
  for (const Step& step : steps_) {
    const double ahead_m = s.drive * step.ahead_m;
    const double turn_rad = s.turn * step.turn_rad + s.drift_rad_per_m * ahead_m;
    moves_.push_back(arc_end({ahead_m, s.side * step.side_m, turn_rad}));
    poses_.push_back(compose(poses_.back(), moves_.back()));
  }
}

/// Of the last reading at that time or earlier, but not the last of all.
std::size_t OdometryPath::before(double time_s) const {
  const auto after = std::upper_bound(times_s_.begin() + 1, times_s_.end() - 1, time_s);
  return static_cast<std::size_t>(after - times_s_.begin()) - 1;
}

Pose OdometryPath::at(double time_s) const {
  if (times_s_.size() < 2) return {};
  if (time_s <= times_s_.front()) return poses_.front();
  if (time_s >= times_s_.back()) return poses_.back();
  const std::size_t k = before(time_s);
  const double part = (time_s - times_s_[k]) / (times_s_[k + 1] - times_s_[k]);
  return compose(poses_[k], along_arc(moves_[k], part));
}

double OdometryPath::raw_heading_rad(double time_s) const {
  if (times_s_.size() < 2) return 0.0;
  if (time_s <= times_s_.front()) return headings_rad_.front();
  if (time_s >= times_s_.back()) return headings_rad_.back();
  const std::size_t k = before(time_s);
  const double part = (time_s - times_s_[k]) / (times_s_[k + 1] - times_s_[k]);
  return headings_rad_[k] + part * (headings_rad_[k + 1] - headings_rad_[k]);
}

}  // namespace parloc
