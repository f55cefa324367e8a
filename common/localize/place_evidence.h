// How much the scans of the last metres speak for each of several places.
#pragma once

#include <cstddef>
#include <vector>

#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/search/scan_evidence.h"

namespace parloc {

/// Where the robot may be now, and what the scans say of it.
struct JudgedPlace {
  Pose pose;                ///< Map frame.
  double evidence = 0.0;    ///< Mean over the scans [nat per beam].
  double attainable = 0.0;  ///< What it could be there (ScanEvidence).
  double share = 0.0;       ///< Of the belief, if these are all places that there are.

  /// Whether the scans may have been taken there: one of which this is true nowhere is bad itself.
  bool fits() const { return evidence >= kFittingShare * attainable; }
  static constexpr double kFittingShare = 0.4;
};

/// The most likely first.
void sort_by_share(std::vector<JudgedPlace>& places);

/// From one spot two places of a map may look alike, the more so among things that are not on it. So a place
/// is judged by every scan that is remembered, each where the robot would have been by its odometry. There
/// are few, close together: the odometry's drift from the first to the last matters little. Deterministic on
/// every machine.
class PlaceEvidence {
 public:
  /// `effective_beams`: independent beams that a scan is worth. Throws as ScanEvidence.
  PlaceEvidence(const GridMap& map, double effective_beams);

  void forget();
  /// Becomes ready for LiDARs that reach so far [m]: the first scan of one takes milliseconds longer.
  void learn(double range_max_m) { evidence_.learn(static_cast<float>(range_max_m), ScanEvidence::kPlaces); }
  /// Remembers on another map what `before` remembers, and what was set there. Scans only if cells are as
  /// large.
  void go_on_from(PlaceEvidence&& before);
  std::size_t remembered() const { return scans_.size(); }
  /// Independent beams that the verdicts of now rest on: differences of evidence times this are log-odds.
  double worth() const;
  /// Whether it was taken: takes the scan if the robot has moved enough since the last that was taken;
  /// forgets the oldest.
  bool remember(const Pose& odometry, const BeamTable& beams);

  /// Evidence of one scan for a pose in the map frame [nat per beam].
  double evidence(const BeamTable& beams, const Pose& pose_in_map);

  bool fits(const BeamTable& beams, const Pose& pose_in_map);  ///< As JudgedPlace.
  /// Of that call: what a scan from there can tell at all (ScanEvidence).
  double attainable() const { return evidence_.attainable(); }

  /// Of that call: the ranges that the map shows there, by beam [m].
  const std::vector<float>& expected_m() const { return evidence_.expected_m(); }
  /// Share of the beams that see nothing wherever they look (MissingReturns), from now on.
  void set_lost(double share) { lost_ = share; }

  /// Each place where the robot may be now, its odometry being `odometry`; by the scan at hand and those
  /// remembered. In the same order.
  std::vector<JudgedPlace> judge(const std::vector<Pose>& places_in_map, const Pose& odometry,
                                 const BeamTable& beams);

 private:
  struct Remembered {
    Pose odometry;
    BeamTable beams;
  };
  ScanEvidence evidence_;
  Pose T_map_grid_;
  double resolution_m_, effective_beams_, lost_ = 0.0;
  std::vector<Remembered> scans_;  // the newest last
};

}  // namespace parloc
