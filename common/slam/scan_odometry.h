// Odometry from scans alone: each scan is matched to a local map of the last ones.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/slam/matching/scan_matcher.h"
#include "common/slam/scan_odometry_counts.h"

namespace parloc {

/// A scan that was drawn into the local map.
struct KeyScan {
  BeamTable beams;
  Pose pose;  ///< Odometry frame.
  std::size_t lidar = 0;
};

/// All that the next scan's pose depends on; the local map is `keys`, drawn in their order.
struct ScanOdometryState {
  std::vector<KeyScan> keys;
  Pose origin;  ///< Of the local map; odometry frame.
  Pose pose;    ///< At the last scan.
  double stamp_s = 0.0;
  Pose step;            ///< The last one that a time is known of.
  double step_s = 0.0;  ///< That time; 0: none yet.
  std::size_t unfit_in_a_row = 0;
  ScanOdometryCounts counts;
};

/// Deterministic: the same bits on every machine, with every matcher. Not thread-safe.
class ScanOdometry {
 public:
  /// The matcher is used for this alone.
  explicit ScanOdometry(std::unique_ptr<ScanMatcher> matcher);

  /// Pose of the base at the scan; the first scan's is the origin. `lidar`: which one took it; `enough`:
  /// whether its beams are worth a match.
  Pose step(double stamp_s, const BeamTable& beams, std::size_t lidar, bool enough);
  const ScanOdometryState& state() const { return state_; }
  /// Goes on from there, to the same bits.
  void restore(ScanOdometryState state);

 private:
  Pose predicted(double stamp_s) const;
  float match(const BeamTable& beams, Pose& pose);
  float match_far(const BeamTable& beams, Pose& pose, float least);
  void note_step(double stamp_s, const Pose& pose, bool fits);
  bool is_key(std::size_t lidar) const;
  void add_key(const BeamTable& beams, std::size_t lidar);
  void keep_keys(std::size_t kept);
  void draw_keys();

  std::unique_ptr<ScanMatcher> matcher_;
  SearchRules near_, far_;
  ClimbRules held_climb_;  ///< Held back to its start.
  ScanOdometryState state_;
};

}  // namespace parloc
