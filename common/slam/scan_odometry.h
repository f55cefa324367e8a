// Odometry from scans alone: each scan is matched to a local map of the last ones.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/slam/scan_odometry_counts.h"
#include "common/slam/slam_config.h"

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
  Pose step;            ///< The last one that a time is known of ...
  double step_s = 0.0;  ///< ... and that time; 0: none yet.
  std::size_t unfit_in_a_row = 0;
  ScanOdometryCounts counts;
};

/// Deterministic, the same bits on every machine. Defined in cpu/scan_odometry.cpp: it works in host memory,
/// whatever the backend.
class ScanOdometry {
 public:
  explicit ScanOdometry(const SlamConfig& config);
  ~ScanOdometry();
  ScanOdometry(ScanOdometry&&) noexcept;

  /// Pose of the base at the scan; the first scan's is the origin. `lidar`: which one took it; `enough`:
  /// whether its beams are worth a match.
  Pose step(double stamp_s, const BeamTable& beams, std::size_t lidar, bool enough);
  const ScanOdometryState& state() const;
  /// Goes on from there, to the same bits.
  void restore(ScanOdometryState state);

 private:
  struct Matcher;
  std::unique_ptr<Matcher> matcher_;
};

}  // namespace parloc
