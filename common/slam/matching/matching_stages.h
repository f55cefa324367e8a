// THE STAGES OF SCAN MATCHING, under the same names in cpu/ and cuda/; ScanMatcher calls them. Each map has a
// frame of its own, in which the poses are (m, rad); cells are counted from its origin. Scans are
// matched by their hits alone, and drawn by them, or with what saw nothing (DrawRules::clear_cells).
//
// clang-format off
// | stage       | reads                                          | writes                                            |
// |-------------|------------------------------------------------|---------------------------------------------------|
// | draft_maps  | scans and their poses, any number for each map | cells, occupied bits and tables of these maps     |
// | match_scans | tasks: a map, a scan, a start and rules each   | found: the best pose of each, and how well it fits |
// clang-format on
//
// Scans of one map are drawn in their order, to the same cells as by register_scan. Tasks do not depend on
// each other: any number of them in one call, at any number of threads, gives the same bits.
#pragma once

#include "common/slam/matching/draw.h"
#include "common/slam/matching/match_scan.h"

namespace parloc {

/// One task of match_scans; all in the backend's memory.
struct MatchTask : ScanSearchRules {
  TileMap map;
  Beams scan;
  SlamPose start;
};

/// What became of it.
struct FoundPose {
  SlamPose pose;
  float fit = 0;  ///< Mean score of the beams that are matched: 1 if all ended where earlier ones did.
};

PARLOC_HD FoundPose found_pose(const ScanSearch& search, std::size_t beams) {
  const float all = kScoreUnits * static_cast<float>(beams);
  return {search.pose(), beams > 0 ? static_cast<float>(search.score()) / all : 0.0f};
}

}  // namespace parloc
