// Sums over the beams of a scan at many poses: a block's first thread decides which, its warps answer, one
// pose each.
#pragma once

#include "common/math/atomics.h"
#include "common/slam/matching/match_scan.h"
#include "cuda/launch.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Shared by the threads of a block.
struct PoseSums {
  static constexpr unsigned kLanes = 32;  ///< A warp adds up the beams of one pose.

  /// By turns: while one round's are read, the next one's are cleared. Two's complement, so that sums of
  /// either sign wrap alike.
  std::uint32_t sum[2][ScanSearch::kMostPoses];
  int wanted;  ///< Poses that the search asks for; none once it is done.

  /// For round `round`, by all threads.
  PARLOC_HD void clear(unsigned thread, int round) {
    for (unsigned k = thread; k < ScanSearch::kMostPoses; k += kThreads) sum[round % 2][k] = 0;
  }
  /// At `poses` of the search's candidates. Each warp works out for itself where they are.
  template <class Search, class Rules>
  PARLOC_HD void answer(const Thread& me, int round, int poses, const Search& search, const Rules& rules,
                        const TileMap& map, const Beams& beams, const MatchRules& match) {
    for (unsigned k = me.thread / kLanes; k < static_cast<unsigned>(poses); k += kThreads / kLanes) {
      const MatchPose pose = match_pose(search.candidate(static_cast<int>(k), rules), match);
      const std::int32_t part = sum_beams(map, beams, pose, match, search.ask(), me.thread % kLanes, kLanes);
      atomic_add(&sum[round % 2][k], static_cast<std::uint32_t>(part));
    }
  }
  PARLOC_HD const std::int32_t* sums(int round) const {
    return reinterpret_cast<const std::int32_t*>(sum[round % 2]);
  }
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
