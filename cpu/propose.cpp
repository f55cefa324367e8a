#include "cpu/match_sum.h"
#include "cpu/slam_stages.h"

namespace parloc::cpu {

void SlamStages::propose(const SlamArgs& given, Queue& workers) {
  const SlamArgs args = with_input(given);
  const ProposeRules& rules = args.rules;
  const Particles& p = args.particles;
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    std::int32_t sum[Proposer::kMostPoses];
    Proposer::Room room;
    BeamSums sums;
    for (std::size_t i = begin; i < end; ++i) {
      const TileMap map = args.maps.of(i);
      keep_one(args, i);
      Proposer proposer;
      proposer.begin(slam_pose(p, i), static_cast<std::uint32_t>(i), rules);
      while (!proposer.done()) {
        const int wanted = proposer.wanted();
        for (int k = 0; k < wanted; ++k)
          sum[k] = sums.sum(map, args.beams, match_pose(proposer.candidate(k, rules), rules.match),
                            rules.match, proposer.ask());
        proposer.take(sum, room, rules);
      }
      p.x[i] = proposer.pose().x, p.y[i] = proposer.pose().y, p.theta[i] = proposer.pose().theta;
      p.log_weight[i] += proposer.log_weight();
      args.likelihood[i] += proposer.log_weight();
    }
  };
  parallel_blocks(p.count(), workers.threads, 1, loop);
}

}  // namespace parloc::cpu
