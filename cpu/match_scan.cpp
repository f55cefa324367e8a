#include "cpu/match_scan.h"

#include "common/math/portable64.h"
#include "cpu/match_sum.h"
#include "cpu/parallel.h"

namespace parloc::cpu {
namespace {

std::size_t count_matched(const MatchRules& rules, const Beams& beams) {
  std::size_t matched = 0;
  for (std::size_t m = 0; m < beams.hits; ++m) matched += beams.range_m[m] <= rules.usable_m ? 1 : 0;
  return matched;
}

}  // namespace

SlamPose slam_pose(const Pose& p) {
  return {static_cast<float>(p.x_m), static_cast<float>(p.y_m), static_cast<float>(p.theta_rad)};
}
Pose pose_of(const SlamPose& p) {
  return {double{p.x}, double{p.y}, wrap64(double{p.theta})};
}

ScanMatch match_scan(const MatchScanRules& rules, const TileMap& map, const Beams& beams,
                     const SlamPose& start) {
  ScanMatch found{start, 0.0f};
  const std::size_t matched = count_matched(rules.match, beams);
  if (matched == 0) return found;
  BeamSums beam_sums;
  const auto sums = [&](const auto& search, Ask ask, std::int32_t* sum,
                        const auto& candidate) PARLOC_SIMD_LOOP {
    for (int k = 0, n = search.wanted(); k < n; ++k)
      sum[k] = beam_sums.sum(map, beams, match_pose(candidate(k), rules.match), rules.match, ask);
  };
  const StrictFloat strict;
  run_simd([&]() PARLOC_SIMD_LOOP {
    std::int32_t sum[WideSearch::kBatch], bound[WideSearch::kMostBlocks];
    WideSearch search;
    search.begin(start, rules.search, matched);
    while (rules.search.any() && !search.done()) {
      sums(search, search.asks_bounds() ? Ask::bound : Ask::score, sum,
           [&](int k) PARLOC_SIMD_LOOP { return search.candidate(k, rules.search); });
      search.take(sum, bound, rules.search);
    }
    HillClimb climb;
    climb.begin(search.pose(), rules.climb, matched);
    while (!climb.done()) {
      sums(climb, Ask::score, sum, [&](int k) PARLOC_SIMD_LOOP { return climb.candidate(k); });
      climb.take(sum);
    }
    found.pose = climb.pose();
    found.fit = static_cast<float>(climb.score()) / (kScoreUnits * static_cast<float>(matched));
  });
  return found;
}

std::vector<float> fits_at(const MatchRules& rules, const TileMap& map, const Beams& beams,
                           const std::vector<SlamPose>& poses) {
  std::vector<float> fits(poses.size(), 0.0f);
  const std::size_t matched = count_matched(rules, beams);
  if (matched == 0) return fits;
  BeamSums beam_sums;
  const StrictFloat strict;
  run_simd([&]() PARLOC_SIMD_LOOP {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const std::int32_t sum = beam_sums.sum(map, beams, match_pose(poses[k], rules), rules, Ask::score);
      fits[k] = static_cast<float>(sum) / (kScoreUnits * static_cast<float>(matched));
    }
  });
  return fits;
}

}  // namespace parloc::cpu
