#include "common/slam/matching/draw.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// No mark yet; and whether the tables reach so far.
struct BeginMarks {
  SlamArgs args;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t particles = args.particles.count();
    for (std::size_t i = me.first(); i < particles; i += me.stride())
      if (!is_covered(args, i)) atomic_add(&args.tally->beyond, 1u);
    ClearMarks{args.touched, particles * args.maps.span.size()}(me);
  }
};

/// A thread per particle and beam.
struct MarkTiles {
  SlamArgs given;
  PARLOC_HD void operator()(const Thread& me) const {
    const SlamArgs args = with_input(given);
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
  launch(BeginMarks{args}, blocks_for(count), queue);
  launch(MarkTiles{args}, blocks_for(particles * args.most_beams), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
