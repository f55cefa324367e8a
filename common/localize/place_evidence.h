// How much the scans of the last metres speak for each of several places.
#pragma once

#include <cstddef>
#include <vector>

#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/search/scan_evidence.h"

namespace parloc {

/// From one spot two places of a map may look alike, the more so among things that are not on it. So a place
/// is judged by every scan that is remembered, each where the robot would have been by its odometry. There
/// are few, close together: the odometry's drift from the first to the last matters little. Deterministic on
/// every machine.
class PlaceEvidence {
 public:
  /// `effective_beams`: independent beams that a scan is worth. Throws as ScanEvidence.
  PlaceEvidence(const GridMap& map, double effective_beams);

  void forget();
  std::size_t remembered() const { return scans_.size(); }
  /// Independent beams that the verdicts of now rest on: differences of evidence times this are log-odds.
  double worth() const;
  /// Whether it was taken: takes the scan if the robot has moved enough since the last that was taken;
  /// forgets the oldest.
  bool remember(const Pose& odometry, const BeamTable& beams);

  /// Evidence of one scan for a pose in the map frame [nat per beam].
  double evidence(const BeamTable& beams, const Pose& pose_in_map);

  /// Of that call: what a scan from there can tell at all (ScanEvidence).
  double attainable() const { return evidence_.attainable(); }

  struct Verdict {
    double evidence = 0.0;  ///< Mean over the scans [nat per beam].
    double share = 0.0;     ///< Of the belief, if these are all places that there are.
  };
  /// For each place where the robot may be now, its odometry being `odometry`; by the scan at hand and those
  /// remembered.
  std::vector<Verdict> judge(const std::vector<Pose>& places_in_map, const Pose& odometry,
                             const BeamTable& beams);

 private:
  struct Remembered {
    Pose odometry;
    BeamTable beams;
  };
  ScanEvidence evidence_;
  Pose T_map_grid_;
  double effective_beams_;
  std::vector<Remembered> scans_;  // the newest last
};

}  // namespace parloc
