#include "common/slam/matching/draw.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// A thread per particle and beam.
struct MarkTiles {
  SlamArgs args;
  PARLOC_HD void operator()(const Thread& me) const {
    const Beams& beams = args.beams;
    const std::size_t drawn = drawn_beams(beams, args.draw);
    const TileSpan& span = args.maps.span;
    for (std::size_t k = me.first(); k < args.particles.count() * drawn; k += me.stride()) {
      const std::size_t i = k / drawn;
      const MatchPose pose = match_pose(slam_pose(args.particles, i), args.rules.match);
      walk_beam(drawn_beam(beams, k % drawn, pose, args.draw),
                MarkTile{span, args.touched + i * span.size()});
    }
  }
};

}  // namespace

void SlamStages::mark_tiles(const SlamArgs& args, Queue& queue) {
  const std::size_t particles = args.particles.capacity, count = particles * args.maps.span.size();
  launch(ClearMarks{args.touched, count}, blocks_for(count), queue);
  launch(MarkTiles{args}, blocks_for(particles * drawn_beams(args.beams, args.draw)), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
