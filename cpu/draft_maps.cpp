#include "cpu/draft_maps.h"

#include "common/filter/bind.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

DraftMap::DraftMap(const MatcherRules& rules) : rules_(rules) {
  new_tile();
}

void DraftMap::clear() {
  span_ = {};
  table_.clear(), touched_.clear();
  used_ = kNoTile + 1;
}

std::uint32_t DraftMap::new_tile() {
  const std::uint32_t id = used_++;
  if (id >= chunk_.size() * kChunkTiles) {
    memory_.push_back(std::make_unique_for_overwrite<Tile[]>(kChunkTiles));
    chunk_.push_back(memory_.back().get());
  }
  chunk_[id >> kChunkShift][id & (kChunkTiles - 1)] = Tile{};
  return id;
}

void DraftMap::cover(const std::vector<ScanDrawing>& drawings) {
  const TileSpan span = span_with(span_, drawings, rules_.draw);
  if (span.size() == span_.size()) return;
  table_ = moved_tables(table_, span_, span, 1);
  touched_.assign(table_.size(), 0);
  span_ = span;
}

void DraftMap::draw(const ScanDrawing& drawing) {
  const Beams beams = bind_beams(*drawing.scan);
  const std::size_t drawn = drawn_beams(beams, rules_.draw);
  const MatchPose at = match_pose(slam_pose(drawing.pose), rules_.match);
  const StrictFloat strict;
  run_simd([&]() PARLOC_SIMD_LOOP {
    for (std::size_t m = 0; m < drawn; ++m)
      walk_beam(drawn_beam(beams, m, at, rules_.draw), MarkTile{span_, touched_.data()});
  });
  for (std::size_t k = 0; k < touched_.size(); ++k)
    if (touched_[k] != 0 && table_[k] == kNoTile) table_[k] = new_tile();
  const TileMap map = view();
  run_simd([&]() PARLOC_SIMD_LOOP {
    for (std::size_t m = 0; m < drawn; ++m) {
      const DrawnBeam b = drawn_beam(beams, m, at, rules_.draw);
      walk_beam(b, DrawCell<PlainAdd>{&b, map, {}});
    }
    for (std::size_t k = 0; k < touched_.size(); ++k) {
      if (touched_[k] == 0) continue;
      for (std::int32_t j = 0; j < kTileCells; ++j) tidy_row(map.pool.at(map.table[k]), j);
      touched_[k] = 0;
    }
  });
}

void DraftMaps::make(std::size_t maps) {
  while (map_.size() < maps) map_.emplace_back(rules_);
}

void DraftMaps::clear() {
  for (DraftMap& map : map_) map.clear();
}

TileMap DraftMaps::view(std::size_t map) {
  make(map + 1);
  return map_[map].view();
}

void DraftMaps::draw(const std::vector<ScanDrawing>& drawings) {
  std::vector<std::vector<ScanDrawing>> of(map_.size());
  for (const ScanDrawing& d : drawings) {
    if (d.map >= of.size()) of.resize(d.map + 1);
    of[d.map].push_back(d);
  }
  make(of.size());
  for (std::size_t i = 0; i < of.size(); ++i) map_[i].cover(of[i]);
  parallel_tasks(of.size(), threads_, [&](std::size_t i) {
    for (const ScanDrawing& d : of[i]) map_[i].draw(d);
  });
}

}  // namespace parloc::cpu
