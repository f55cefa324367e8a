#include "common/localize/rivals.h"

#include <algorithm>
#include <limits>

#include "common/math/portable64.h"

namespace parloc {
namespace {

/// Scans that must speak for a place besides the one that it was found by.
constexpr std::size_t kOwnScans = 2;
/// A carrying away is looked for this far back.
constexpr double kLookBack_s = 10.0;
constexpr double kUndecided_m = 4.0;
/// Where the odometry says that a place has moved to, but for its errors since the last scan.
constexpr SlipSearch::Reach kDrift{0.2, 0.1};

}  // namespace

void Rivals::begin(const std::vector<JudgedPlace>& found, std::size_t places, const Pose& odometry) {
  clear();
  for (const JudgedPlace& place : found)
    if (place.share >= kNoMatter && place.fits()) poses_.push_back(place.pose);
  odometry_ = found_ = odometry;
  places_ = places;
}

void Rivals::follow(const Pose& odometry) {
  const Pose motion = relative(odometry, odometry_);
  odometry_ = odometry;
  for (Pose& pose : poses_) pose = compose(pose, motion);
  if (distance_m(found_, odometry) > kUndecided_m) clear();
}

std::vector<JudgedPlace> Rivals::weigh(const std::vector<Mode>& tracked, const BeamTable& beams,
                                       PlaceEvidence& judge, SlipSearch& near_by, double carried_per_hour) {
  ++scans_;
  for (Pose& pose : poses_)
    if (const auto better = near_by.look(beams, pose, kDrift)) pose = better->pose;
  std::vector<Pose> places = poses_;
  for (const Mode& mode : tracked) places.push_back(mode.pose);
  const std::vector<JudgedPlace> judged = judge.judge(places, odometry_, beams);
  double here = -std::numeric_limits<double>::infinity(), best = 0.0;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    if (k >= poses_.size()) here = std::max(here, judged[k].evidence);
    best = std::max(best, judged[k].share);
  }
  const double price = portable_log64(3600.0 / (carried_per_hour * kLookBack_s)) +
                       portable_log64(1.0 + static_cast<double>(places_));
  std::vector<JudgedPlace> paid;
  for (std::size_t k = 0; k < poses_.size() && scans_ >= kOwnScans; ++k) {
    const JudgedPlace& place = judged[k];
    const bool pays = judge.worth() * (place.evidence - here) >= price;
    if (pays && place.fits() && place.share >= kNoMatter * best) paid.push_back(place);
  }
  sort_by_share(paid);
  return paid;
}

}  // namespace parloc
