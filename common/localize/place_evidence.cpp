#include "common/localize/place_evidence.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable.h"
#include "common/search/hypotheses.h"

namespace parloc {
namespace {

constexpr std::size_t kMost = 6;  ///< Scans remembered.
/// Between scans that are remembered.
constexpr Separation kApart{0.3, 0.3};

}  // namespace

PlaceEvidence::PlaceEvidence(const GridMap& map, double effective_beams)
    : evidence_(map), T_map_grid_(map.T_map_grid), effective_beams_(effective_beams) {}

void PlaceEvidence::forget() {
  scans_.clear();
}

bool PlaceEvidence::remember(const Pose& odometry, const BeamTable& beams) {
  if (beams.count == 0 || (!scans_.empty() && !separated(odometry, scans_.back().odometry, kApart)))
    return false;
  if (scans_.size() == kMost) scans_.erase(scans_.begin());
  scans_.push_back({odometry, beams});
  return true;
}

/// Scans of one neighbourhood see much the same: n of them are worth sqrt(n).
double PlaceEvidence::worth() const {
  return effective_beams_ * std::sqrt(static_cast<double>(scans_.size() + 1));
}

double PlaceEvidence::evidence(const BeamTable& beams, const Pose& pose_in_map) {
  return evidence_.per_beam(beams, relative(pose_in_map, T_map_grid_));
}

std::vector<PlaceEvidence::Verdict> PlaceEvidence::judge(const std::vector<Pose>& places_in_map,
                                                         const Pose& odometry, const BeamTable& beams) {
  const double scans = static_cast<double>(scans_.size() + 1);
  std::vector<Verdict> verdicts;
  for (const Pose& place : places_in_map) {
    double sum = evidence(beams, place);
    for (const Remembered& then : scans_)
      sum += evidence(then.beams, compose(place, relative(then.odometry, odometry)));
    verdicts.push_back({sum / scans, 0.0});
  }
  double best = verdicts.empty() ? 0.0 : verdicts[0].evidence, total = 0.0;
  for (const Verdict& v : verdicts) best = std::max(best, v.evidence);
  for (Verdict& v : verdicts) {
    v.share = portable_exp(static_cast<float>(worth() * (v.evidence - best)));
    total += v.share;
  }
  for (Verdict& v : verdicts) v.share /= total;
  return verdicts;
}

}  // namespace parloc
