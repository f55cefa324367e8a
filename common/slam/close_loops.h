// Closing loops after the fact: what is left over of a way's error, distributed over it with a pose graph.
#pragma once

#include <functional>
#include <vector>

#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/slam/loop_counts.h"
#include "common/slam/slam_backend.h"
#include "common/slam/slam_config.h"

namespace parloc {

/// A way with the scans that were taken in on it: as much of each.
struct ScannedPath {
  std::vector<Pose> path;      ///< Map frame, as a particle has it.
  std::vector<Pose> odometry;  ///< At the same scans.
  std::vector<BeamTable> scans;
};

struct ClosedPath {
  std::vector<Pose> path;  ///< Map frame; the first pose is what it was. Without a loop: all are.
  LoopCounts counts;
};

/// Deterministic, the same bits at any number of threads (0: all cores). Defined in cpu/close_loops.cpp: it
/// works in host memory, whatever the backend.
/// `watch` may be empty; it is told how much is done, 0 to 1, and what it throws ends the work.
ClosedPath close_loops(const SlamConfig& config, const ScannedPath& way, int threads,
                       const std::function<void(double fraction)>& watch = {});

/// The map that the scans draw from there.
SlamCells drawn_map(const SlamConfig& config, const std::vector<BeamTable>& scans,
                    const std::vector<Pose>& path);

}  // namespace parloc
