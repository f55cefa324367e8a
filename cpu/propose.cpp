#include "cpu/slam_stages.h"

namespace parloc::cpu {
namespace {

template <class Term>
PARLOC_HD std::int32_t sum_beams(const TileMap& map, const Beams& beams, const SlamPose& pose,
                                 const MatchRules& rules, const Term& term) {
  const MatchPose p = match_pose(pose, rules);
  std::int32_t sum = 0;
  for (std::size_t m = 0; m < beams.hits; ++m) sum += match_term(map, beams, m, p, rules, term);
  return sum;
}

}  // namespace

void propose(const ProposeRules& rules, const Beams& beams, const SlamMaps& maps, const Particles& p,
             float* likelihood, Workers& workers) {
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    std::int32_t sum[Proposer::kMostPoses];
    double log[Proposer::kMostPoses];
    for (std::size_t i = begin; i < end; ++i) {
      const TileMap map = maps.of(i);
      Proposer proposer;
      proposer.begin(slam_pose(p, i), static_cast<std::uint32_t>(i), rules);
      while (!proposer.done()) {
        const int wanted = proposer.wanted();
        const bool score = proposer.ask() == Proposer::Ask::score;
        for (int k = 0; k < wanted; ++k) {
          const SlamPose at = proposer.candidate(k, rules);
          sum[k] = score ? sum_beams(map, beams, at, rules.match, ScoreTerm{})
                         : sum_beams(map, beams, at, rules.match, LikelihoodTerm{});
        }
        proposer.take(sum, log, rules);
      }
      p.x[i] = proposer.pose().x, p.y[i] = proposer.pose().y, p.theta[i] = proposer.pose().theta;
      p.log_weight[i] += proposer.log_weight();
      likelihood[i] += proposer.log_weight();
    }
  };
  parallel_blocks(p.count(), workers.threads, 1, loop);
}

}  // namespace parloc::cpu
