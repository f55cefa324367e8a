// Closing loops after the fact: what is left over of a path's error, distributed over it with a pose graph.
#pragma once

#include <functional>
#include <vector>

#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/slam/loops/loop_counts.h"
#include "common/slam/matching/scan_matcher.h"

namespace parloc {

/// A path with the scans that were taken in on it: as much of each.
struct ScannedPath {
  std::vector<Pose> path;      ///< Map frame, as a particle has it.
  std::vector<Pose> odometry;  ///< At the same scans.
  std::vector<BeamTable> scans;
};

struct ClosedPath {
  std::vector<Pose> path;  ///< Map frame; the first pose is what it was. Without a loop: all are.
  LoopCounts counts;
};

/// Deterministic: the same bits with every matcher. What the matcher had drawn before is forgotten.
/// `watch` may be empty; it is told how much is done, 0 to 1, and what it throws ends the work.
ClosedPath close_loops(const ScannedPath& scanned, ScanMatcher& matcher,
                       const std::function<void(double fraction)>& watch = {});

/// The map that the scans draw from the poses of the path.
SlamCells drawn_map(const std::vector<BeamTable>& scans, const std::vector<Pose>& path, ScanMatcher& matcher);

}  // namespace parloc
