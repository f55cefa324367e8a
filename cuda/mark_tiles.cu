#include "common/slam/matching/draw.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct ClearMarks {
  std::uint8_t* touched;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < count; k += me.stride()) touched[k] = 0;
  }
};

/// A thread per particle and beam.
struct MarkTiles {
  DrawRules rules;
  MatchRules match;
  Beams beams;
  TileSpan span;
  Particles p;
  std::uint8_t* touched;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < p.count() * beams.hits; k += me.stride()) {
      const std::size_t i = k / beams.hits;
      const DrawnBeam b = drawn_beam(beams, k % beams.hits, match_pose(slam_pose(p, i), match), rules);
      walk_beam(b, MarkTile{span, touched + i * span.size()});
    }
  }
};

}  // namespace

void mark_tiles(const DrawRules& rules, const MatchRules& match, const Beams& beams, const TileSpan& span,
                const Particles& p, std::uint8_t* touched, Stream stream) {
  const std::size_t count = p.capacity * span.size();
  launch(ClearMarks{touched, count}, blocks_for(count), stream);
  launch(MarkTiles{rules, match, beams, span, p, touched}, blocks_for(p.capacity * beams.hits), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
