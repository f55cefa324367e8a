// Sums over the beams of a scan at many poses: a block's first thread asks, its warps answer, one pose each.
#pragma once

#include "common/math/atomics.h"
#include "common/slam/matching/match_scan.h"
#include "cuda/launch.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Shared by the threads of a block.
struct PoseSums {
  static constexpr unsigned kLanes = 32;  ///< A warp adds up the beams of one pose.

  MatchPose pose[ScanSearch::kMostPoses];
  std::uint32_t sum[ScanSearch::kMostPoses];  ///< Two's complement, so that sums of either sign wrap alike.
  int wanted;
  Ask asked;

  /// The poses that a search wants to know next; one that is done wants none.
  template <class Search, class Rules>
  PARLOC_HD void ask(const Search& search, const Rules& rules, const MatchRules& match) {
    wanted = search.wanted();
    asked = search.ask();
    for (int k = 0; k < wanted; ++k) {
      pose[k] = match_pose(search.candidate(k, rules), match);
      sum[k] = 0;
    }
  }
  PARLOC_HD void answer(const Thread& me, const TileMap& map, const Beams& beams, const MatchRules& match) {
    for (unsigned k = me.thread / kLanes; k < static_cast<unsigned>(wanted); k += kThreads / kLanes) {
      const std::int32_t part = sum_beams(map, beams, pose[k], match, asked, me.thread % kLanes, kLanes);
      atomic_add(&sum[k], static_cast<std::uint32_t>(part));
    }
  }
  PARLOC_HD const std::int32_t* sums() const { return reinterpret_cast<const std::int32_t*>(sum); }
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
