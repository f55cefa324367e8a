#include "common/model/odometry_track.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable64.h"

namespace parloc {
namespace {

bool earlier(const StampedPose& reading, double stamp_s) {
  return reading.stamp_s < stamp_s;
}

/// On the arc from a to b, before and behind it too. The stamps differ.
Pose on_arc(const StampedPose& a, const StampedPose& b, double stamp_s) {
  const double part = (stamp_s - a.stamp_s) / (b.stamp_s - a.stamp_s);
  return compose(a.pose, along_arc(relative(b.pose, a.pose), part));
}

}  // namespace

void OdometryTrack::add(double stamp_s, const Pose& reading) {
  for (const double v : {stamp_s, reading.x_m, reading.y_m, reading.theta_rad})
    if (!std::isfinite(v)) return;
  const Pose odometry{reading.x_m, reading.y_m, wrap64(reading.theta_rad)};
  if (!readings_.empty() && stamp_s < readings_.back().stamp_s - kRemembered_s) clear();
  const auto place = std::lower_bound(readings_.begin(), readings_.end(), stamp_s, earlier);
  if (place != readings_.end() && place->stamp_s == stamp_s) {
    place->pose = odometry;
    return;
  }
  if (place != readings_.begin()) {
    const Pose& before = (place - 1)->pose;
    const double dx = odometry.x_m - before.x_m, dy = odometry.y_m - before.y_m;
    const double most_m = std::max(longest_step_m_, max_speed_mps_ * (stamp_s - (place - 1)->stamp_s));
    if (!(dx * dx + dy * dy <= most_m * most_m)) {
      readings_.assign(1, {stamp_s, odometry});
      return;
    }
  }
  readings_.insert(place, {stamp_s, odometry});
  const double oldest_s = readings_.back().stamp_s - kRemembered_s;
  readings_.erase(readings_.begin(), std::lower_bound(readings_.begin(), readings_.end(), oldest_s, earlier));
}

bool OdometryTrack::knows_motion() const {
  return readings_.size() > 1 && readings_.back().stamp_s - readings_.front().stamp_s >= kShortestTwist_s;
}

Pose OdometryTrack::motion(double from_s, double to_s, double twist_s) const {
  if (!knows_motion()) return {};
  return relative(at(to_s, twist_s), at(from_s, twist_s));
}

Pose OdometryTrack::at(double stamp_s) const {
  const auto place = std::lower_bound(readings_.begin(), readings_.end(), stamp_s, earlier);
  if (place != readings_.end() && place->stamp_s == stamp_s) return place->pose;
  return knows_motion() ? at(stamp_s, kShortestTwist_s) : readings_.back().pose;
}

Pose OdometryTrack::at(double stamp_s, double twist_s) const {
  const StampedPose &first = readings_.front(), &last = readings_.back();
  if (stamp_s < first.stamp_s) {
    const double far_s = first.stamp_s + twist_s;
    return on_arc(first, *std::lower_bound(readings_.begin(), readings_.end() - 1, far_s, earlier), stamp_s);
  }
  if (stamp_s >= last.stamp_s) {
    const double far_s = last.stamp_s - twist_s;
    auto from = std::lower_bound(readings_.begin(), readings_.end(), far_s, earlier);
    if (from->stamp_s > far_s && from != readings_.begin()) --from;
    return on_arc(*from, last, stamp_s);
  }
  const auto after = std::lower_bound(readings_.begin(), readings_.end(), stamp_s, earlier);
  if (after->stamp_s == stamp_s) return after->pose;
  return on_arc(*(after - 1), *after, stamp_s);
}

}  // namespace parloc
