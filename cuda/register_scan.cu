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
  DrawRules rules;
  MatchRules match;
  Beams beams;
  SlamMaps maps;
  Particles p;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < p.count() * beams.hits; k += me.stride()) {
      const std::size_t i = k / beams.hits;
      const DrawnBeam b = drawn_beam(beams, k % beams.hits, match_pose(slam_pose(p, i), match), rules);
      walk_beam(b, DrawCell<AtomicAdd>{&b, maps.of(i), {}});
    }
  }
};

/// A block per particle, a warp per tile, a thread per row.
struct TidyTiles {
  SlamMaps maps;
  Particles p;
  const std::uint8_t* touched;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t i = me.block, size = maps.span.size();
    for (std::size_t k = me.thread / kTileCells; k < size; k += kThreads / kTileCells)
      if (touched[i * size + k] != 0)
        tidy_row(maps.pool.at(maps.table[i * size + k]), static_cast<std::int32_t>(me.thread % kTileCells));
  }
};

}  // namespace

void register_scan(const DrawRules& rules, const MatchRules& match, const Beams& beams, const SlamMaps& maps,
                   const Particles& p, const std::uint8_t* touched, Stream stream) {
  launch(DrawBeams{rules, match, beams, maps, p}, blocks_for(p.capacity * beams.hits), stream);
  launch(TidyTiles{maps, p, touched}, static_cast<unsigned>(p.capacity), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
