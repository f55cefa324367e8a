#include "common/math/atomics.h"
#include "common/slam/matching/draw.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct AtomicAdd {
  PARLOC_HD void operator()(CellWord* at, CellWord more) const { atomic_add(at, more); }
};

/// A thread per particle and beam.
struct DrawBeams {
  SlamArgs given;
  PARLOC_HD void operator()(const Thread& me) const {
    if (given.tally->fits == 0) return;
    const SlamArgs args = with_input(given);
    const SlamMaps maps = inherited_maps(args);
    const Beams& beams = args.beams;
    const std::size_t drawn = drawn_beams(beams, args.draw);
    for (std::size_t k = me.first(); k < args.particles.count() * drawn; k += me.stride()) {
      const std::size_t i = k / drawn;
      const MatchPose pose = match_pose(slam_pose(args.particles, i), args.rules.match);
      const DrawnBeam b = drawn_beam(beams, k % drawn, pose, args.draw);
      walk_beam(b, DrawCell<AtomicAdd>{&b, maps.of(i), {}});
    }
  }
};

/// A block per particle, a warp per tile, a thread per row.
struct TidyTiles {
  SlamArgs args;
  PARLOC_HD void operator()(const Thread& me) const {
    if (args.tally->fits == 0) return;
    const SlamMaps maps = inherited_maps(args);
    const std::uint8_t* const touched = args.touched;
    const std::size_t i = me.block, size = maps.span.size();
    for (std::size_t k = me.thread / kTileCells; k < size; k += kThreads / kTileCells)
      if (touched[i * size + k] != 0)
        tidy_row(maps.pool.at(maps.table[i * size + k]), static_cast<std::int32_t>(me.thread % kTileCells));
  }
};

}  // namespace

void SlamStages::register_scan(const SlamArgs& args, Queue& queue) {
  const std::size_t particles = args.particles.capacity;
  launch(DrawBeams{args}, blocks_for(particles * args.most_beams), queue);
  launch(TidyTiles{args}, static_cast<unsigned>(particles), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
