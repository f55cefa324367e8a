#include "common/slam/matching/draw.h"
#include "cpu/slam_stages.h"

namespace parloc::cpu {

void SlamStages::register_scan(const SlamArgs& given, Queue& workers) {
  if (given.tally->fits == 0) return;
  const SlamArgs args = with_input(given);
  const SlamMaps maps = inherited_maps(args);
  const Beams& beams = args.beams;
  const std::size_t drawn = drawn_beams(beams, args.draw);
  const std::size_t size = args.maps.span.size();
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t i = begin; i < end; ++i) {
      const TileMap map = maps.of(i);
      const MatchPose pose = match_pose(slam_pose(args.particles, i), args.rules.match);
      for (std::size_t m = 0; m < drawn; ++m) {
        const DrawnBeam b = drawn_beam(beams, m, pose, args.draw);
        walk_beam(b, DrawCell<PlainAdd>{&b, map, {}});
      }
      for (std::size_t k = 0; k < size; ++k) {
        if (args.touched[i * size + k] == 0) continue;
        Tile& tile = map.pool.at(map.table[k]);
        for (std::int32_t j = 0; j < kTileCells; ++j) tidy_row(tile, j);
      }
    }
  };
  parallel_blocks(args.particles.count(), workers.threads, 1, loop);
}

}  // namespace parloc::cpu
