// Whether a filter is where it says: from how its scans fit, and from whether it has made up its mind.
#pragma once

#include "common/filter/pose_filter.h"

namespace parloc {

/// What a localizer is sure of.
enum class HealthState {
  tracking,   ///< One place, and the scans fit it.
  ambiguous,  ///< The scans fit, but several places are possible.
  lost,       ///< The scans do not fit.
};
/// "tracking", "ambiguous" or "lost".
const char* name_of(HealthState state);

/// How far a pose is to be believed.
struct Health {
  double probability = 0.0;  ///< That the pose is within 0.5 m and 10 degrees of the truth.
  double evidence = 0.0;     ///< What the scans say for it, smoothed [nat per beam] (ScanEvidence).
  double log_odds = 0.0;     ///< What they say together, before it is calibrated [nat] (HealthMonitor).
  HealthState state = HealthState::lost;  ///< The same in a word.
};

/// What one scan says of the place that is tracked.
struct ScanFit {
  double evidence = 0.0;    ///< At the estimated pose [nat per beam].
  double attainable = 2.5;  ///< What it could be there (ScanEvidence).
  double share = 0.0;       ///< Weight of the particles around that pose, 0 to 1.
  double novelty = 1.0;     ///< Of the scan (ScanNovelty).
  double within = 1.0;      ///< Probability that the pose is close enough, by its covariance.
};

/// Probability that a pose with this covariance is within 0.5 m and 10 degrees: little along a corridor whose
/// ends were not seen for long.
double probability_within(const Covariance& covariance);

/// Follows one filter: adds up what independent scans say for and against its place, whatever time they take.
/// What a single scan can say is bounded, and so is what a place can earn: one that was right for long is not
/// lost for a bad scan, and one that is wrong is lost after a few. Deterministic on every machine.
class HealthMonitor {
 public:
  /// Forgets what was seen: the filter starts anew, at a place that is right with these odds [nat].
  void reset(double log_odds = 0.0);
  /// Where it is now fits best of all places: that it fits worse than before is the surroundings' doing.
  void accept();
  /// Of what is attainable, the share that scans at a good place reach on this drive, with its people and its
  /// moved shelves.
  double typical() const { return typical_; }

  /// After a scan was weighed. The probability is that of the scans, calibrated (docs/results/health.md),
  /// times the share, times `within`.
  Health update(const ScanFit& fit);

 private:
  static constexpr double kFirstTypical = 0.75;  // of maps that are a little wrong, as all are

  bool seen_ = false, lost_ = false;
  double evidence_ = 0.0;  // smoothed
  double share_ = 0.0;     // of what is attainable, likewise
  double log_odds_ = 0.0;  // of being right
  double typical_ = kFirstTypical;
};

}  // namespace parloc
