#include "cpu/draft_map.h"

#include <algorithm>

#include "common/slam/draw.h"
#include "common/slam/slam_backend.h"
#include "cpu/parallel.h"

namespace parloc::cpu {
DraftMap::DraftMap(const DrawRules& draw, const MatchRules& match) : draw_(draw), match_(match) {
  new_tile();
  clear();
}

void DraftMap::clear() {
  std::fill(table_.begin(), table_.end(), kNoTile);
  used_ = 1;
}

std::uint32_t DraftMap::new_tile() {
  const std::uint32_t id = memory_.empty() ? kNoTile : used_++;
  if (id >= chunk_.size() * kChunkTiles) {
    memory_.push_back(std::make_unique_for_overwrite<Tile[]>(kChunkTiles));
    chunk_.push_back(memory_.back().get());
  }
  chunk_[id >> kChunkShift][id & (kChunkTiles - 1)] = Tile{};
  return id;
}

void DraftMap::cover(const SlamPose& pose) {
  const double cell_m = 1.0 / static_cast<double>(draw_.inv_resolution);
  const double reach_m = static_cast<double>(draw_.usable_cells) * cell_m;
  const TileSpan span = grown_span(span_, {pose.x}, {pose.y}, reach_m, cell_m);
  if (span.size() == span_.size()) return;
  table_ = moved_tables(table_, span_, span, 1);
  touched_.assign(table_.size(), 0);
  span_ = span;
}

void DraftMap::draw(const Beams& beams, const SlamPose& pose) {
  cover(pose);
  const MatchPose at = match_pose(pose, match_);
  const StrictFloat strict;
  run_simd([&]() PARLOC_SIMD_LOOP {
    for (std::size_t m = 0; m < beams.hits; ++m)
      walk_beam(drawn_beam(beams, m, at, draw_), MarkTile{span_, touched_.data()});
  });
  for (std::size_t k = 0; k < touched_.size(); ++k)
    if (touched_[k] != 0 && table_[k] == kNoTile) table_[k] = new_tile();
  const TileMap map = view();
  run_simd([&]() PARLOC_SIMD_LOOP {
    for (std::size_t m = 0; m < beams.hits; ++m) {
      const DrawnBeam b = drawn_beam(beams, m, at, draw_);
      walk_beam(b, DrawCell<PlainAdd>{&b, map, {}});
    }
    for (std::size_t k = 0; k < touched_.size(); ++k) {
      if (touched_[k] == 0) continue;
      for (std::int32_t j = 0; j < kTileCells; ++j) tidy_row(map.pool.at(map.table[k]), j);
      touched_[k] = 0;
    }
  });
}

}  // namespace parloc::cpu
