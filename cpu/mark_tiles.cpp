#include <cstring>

#include "common/slam/matching/draw.h"
#include "cpu/slam_stages.h"

namespace parloc::cpu {

void SlamStages::mark_tiles(const SlamArgs& given, Queue& workers) {
  const SlamArgs args = with_input(given);
  const Beams& beams = args.beams;
  const std::size_t drawn = drawn_beams(beams, args.draw);
  const TileSpan& span = args.maps.span;
  const std::size_t size = span.size();
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint8_t* mine = args.touched + i * size;
      std::memset(mine, 0, size);
      const MatchPose pose = match_pose(slam_pose(args.particles, i), args.rules.match);
      for (std::size_t m = 0; m < drawn; ++m)
        walk_beam(drawn_beam(beams, m, pose, args.draw), MarkTile{span, mine});
    }
  };
  parallel_blocks(args.particles.count(), workers.threads, 1, loop);
  for (std::size_t i = 0; i < args.particles.count(); ++i) args.tally->beyond += is_covered(args, i) ? 0 : 1;
}

}  // namespace parloc::cpu
