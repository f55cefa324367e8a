#include "common/localize/rivals.h"

#include <algorithm>
#include <limits>

#include "common/math/portable64.h"

namespace parloc {
namespace {

/// Evidence of a scan at a place where it may have been taken [nat per beam], and the least share of the
/// belief.
constexpr double kFits = 1.0, kNoMatter = 0.01;
/// Scans that must speak for a place besides the one that it was found by.
constexpr std::size_t kOwnScans = 2;
/// A carrying away is looked for this far back.
constexpr double kLookBack_s = 10.0;
constexpr double kUndecided_m = 4.0;
/// Where the odometry says that a place has moved to, but for its errors since the last scan.
constexpr SlipSearch::Reach kDrift{0.2, 0.1};

}  // namespace

void Rivals::begin(const std::vector<Hypothesis>& found, std::size_t places, const Pose& odometry) {
  clear();
  for (const Hypothesis& h : found)
    if (h.weight >= kNoMatter && h.evidence >= kFits) poses_.push_back(h.pose);
  odometry_ = found_ = odometry;
  places_ = places;
}

void Rivals::follow(const Pose& odometry) {
  const Pose motion = relative(odometry, odometry_);
  odometry_ = odometry;
  for (Pose& pose : poses_) pose = compose(pose, motion);
  if (distance_m(found_, odometry) > kUndecided_m) clear();
}

std::vector<Hypothesis> Rivals::weigh(const std::vector<Mode>& tracked, const BeamTable& beams,
                                      PlaceEvidence& judge, SlipSearch& near_by, double carried_per_hour) {
  ++scans_;
  for (Pose& pose : poses_)
    if (const auto better = near_by.look(beams, pose, kDrift)) pose = better->pose;
  std::vector<Pose> places = poses_;
  for (const Mode& mode : tracked) places.push_back(mode.pose);
  const std::vector<PlaceEvidence::Verdict> verdicts = judge.judge(places, odometry_, beams);
  double here = -std::numeric_limits<double>::infinity(), best = 0.0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (k >= poses_.size()) here = std::max(here, verdicts[k].evidence);
    best = std::max(best, verdicts[k].share);
  }
  const double price = portable_log64(3600.0 / (carried_per_hour * kLookBack_s)) +
                       portable_log64(1.0 + static_cast<double>(places_));
  std::vector<Hypothesis> paid;
  for (std::size_t k = 0; k < poses_.size() && scans_ >= kOwnScans; ++k) {
    const PlaceEvidence::Verdict& v = verdicts[k];
    if (judge.worth() * (v.evidence - here) < price || v.evidence < kFits || v.share < kNoMatter * best)
      continue;
    Hypothesis h;
    h.pose = poses_[k], h.evidence = v.evidence, h.weight = v.share;
    paid.push_back(h);
  }
  std::stable_sort(paid.begin(), paid.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.weight > b.weight; });
  return paid;
}

}  // namespace parloc
