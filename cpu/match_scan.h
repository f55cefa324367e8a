// One scan against one map, on the host: what `propose` does for a particle, without odometry and weights.
#pragma once

#include <vector>

#include "common/math/pose.h"
#include "common/slam/propose.h"

namespace parloc::cpu {

SlamPose slam_pose(const Pose& p);
Pose pose_of(const SlamPose& p);

struct MatchScanRules {
  MatchRules match;
  SearchRules search;
  ClimbRules climb;
};

struct ScanMatch {
  SlamPose pose;
  float fit = 0;  ///< Mean score of the beams that are matched: 1 if all ended where earlier ones did.
};

/// From `start`, a search of the window and a climb. Deterministic.
ScanMatch match_scan(const MatchScanRules& rules, const TileMap& map, const Beams& beams,
                     const SlamPose& start);

/// The same mean score at each of the poses.
std::vector<float> fits_at(const MatchRules& rules, const TileMap& map, const Beams& beams,
                           const std::vector<SlamPose>& poses);

}  // namespace parloc::cpu
