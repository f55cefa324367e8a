#include <cstring>

#include "common/slam/matching/draw.h"
#include "cpu/slam_stages.h"

namespace parloc::cpu {

void mark_tiles(const DrawRules& rules, const MatchRules& match, const Beams& beams, const TileSpan& span,
                const Particles& p, std::uint8_t* touched, Workers& workers) {
  const std::size_t size = span.size();
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint8_t* mine = touched + i * size;
      std::memset(mine, 0, size);
      const MatchPose pose = match_pose(slam_pose(p, i), match);
      for (std::size_t m = 0; m < beams.hits; ++m)
        walk_beam(drawn_beam(beams, m, pose, rules), MarkTile{span, mine});
    }
  };
  parallel_blocks(p.count(), workers.threads, 1, loop);
}

}  // namespace parloc::cpu
