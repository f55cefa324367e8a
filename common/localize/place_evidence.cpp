#include "common/localize/place_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/portable.h"
#include "common/search/hypotheses.h"

namespace parloc {
namespace {

constexpr std::size_t kMost = 6;  ///< Scans remembered.
/// Between scans that are remembered.
constexpr Separation kApart{0.3, 0.3};

}  // namespace

void sort_by_share(std::vector<JudgedPlace>& places) {
  std::stable_sort(places.begin(), places.end(),
                   [](const JudgedPlace& a, const JudgedPlace& b) { return a.share > b.share; });
}

PlaceEvidence::PlaceEvidence(const GridMap& map, double effective_beams)
    : evidence_(map),
      T_map_grid_(map.T_map_grid),
      resolution_m_(map.resolution_m),
      effective_beams_(effective_beams) {}

void PlaceEvidence::forget() {
  scans_.clear();
}

void PlaceEvidence::go_on_from(PlaceEvidence&& before) {
  lost_ = before.lost_;
  if (resolution_m_ == before.resolution_m_) scans_ = std::move(before.scans_);  // their ends are in cells
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
  return evidence_.per_beam(beams, relative(pose_in_map, T_map_grid_), lost_);
}

bool PlaceEvidence::fits(const BeamTable& beams, const Pose& pose_in_map) {
  const double says = evidence(beams, pose_in_map);
  return JudgedPlace{pose_in_map, says, attainable()}.fits();
}

std::vector<JudgedPlace> PlaceEvidence::judge(const std::vector<Pose>& places_in_map, const Pose& odometry,
                                              const BeamTable& beams) {
  const double per_scan = 1.0 / static_cast<double>(scans_.size() + 1);
  std::vector<JudgedPlace> judged;
  for (const Pose& place : places_in_map) {
    JudgedPlace& j = judged.emplace_back(JudgedPlace{place, evidence(beams, place), attainable()});
    for (const Remembered& then : scans_) {
      j.evidence += evidence(then.beams, compose(place, relative(then.odometry, odometry)));
      j.attainable += attainable();
    }
    j.evidence *= per_scan;
    j.attainable *= per_scan;
  }
  double best = judged.empty() ? 0.0 : judged[0].evidence, total = 0.0;
  for (const JudgedPlace& j : judged) best = std::max(best, j.evidence);
  for (JudgedPlace& j : judged) {
    j.share = portable_exp(static_cast<float>(worth() * (j.evidence - best)));
    total += j.share;
  }
  for (JudgedPlace& j : judged) j.share /= total;
  return judged;
}

}  // namespace parloc
