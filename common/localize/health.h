// Whether a filter is where it says: from how its scans fit, and from whether it has made up its mind.
#pragma once

namespace parloc {

enum class HealthState {
  tracking,   ///< One place, and the scans fit it.
  ambiguous,  ///< The scans fit, but several places are possible.
  lost,       ///< The scans do not fit.
};
const char* name_of(HealthState state);

struct Health {
  double probability = 0.0;  ///< That the pose is within 0.5 m and 10 degrees of the truth.
  double evidence = 0.0;     ///< What the scans say for it, smoothed [nat per beam] (ScanEvidence).
  HealthState state = HealthState::lost;
};

/// Follows one filter. Deterministic on every machine.
class HealthMonitor {
 public:
  /// Forgets what was seen: the filter starts anew.
  void reset();

  /// After a scan was weighed. `evidence` is that of the scan at the estimated pose, `share` the weight of
  /// the particles around that pose, 0 to 1. The probability is that of the scans, calibrated
  /// (docs/localize.md), times the share.
  Health update(double stamp_s, double evidence, double share);

 private:
  bool seen_ = false, lost_ = false;
  double last_s_ = 0.0;
  double evidence_ = 0.0;
};

}  // namespace parloc
