#include "cpu/draft_maps.h"

#include <algorithm>

#include "common/filter/bind.h"
#include "cpu/parallel.h"

namespace parloc::cpu {
namespace {

/// A beam that is drawn, and the tiles that it comes to.
struct DrawAndMark {
  DrawCell<PlainAdd> draw;
  MarkTile mark;
  PARLOC_HD void operator()(std::int32_t i, std::int32_t j, bool last) const {
    draw(i, j, last);
    mark(i, j, last);
  }
};

/// Of the tiles that are marked; no mark is left.
PARLOC_HD void tidy_marked(const TileMap& map, std::uint8_t* touched) {
  for (std::size_t k = 0; k < map.span.size(); ++k) {
    if (touched[k] == 0) continue;
    for (std::int32_t j = 0; j < kTileCells; ++j) tidy_row(map.pool.at(map.table[k]), j);
    touched[k] = 0;
  }
}

}  // namespace

void DraftMaps::clear() {
  count_ = 0;
  span_ = {};
  table_.clear(), touched_.clear();
  store_.set_refs(count_references(table_, store_.capacity()));
}

void DraftMaps::cover(const std::vector<ScanDrawing>& drawings) {
  const TileSpan span = span_with(span_, drawings, rules_.draw);
  const std::size_t count = maps_with(count_, drawings);
  if (span.size() == span_.size() && count == count_) return;
  table_ = moved_tables(table_, span_, span, count_);
  table_.resize(count * span.size(), kNoTile);
  touched_.assign(table_.size(), 0);
  span_ = span;
  count_ = count;
}

void DraftMaps::draw(const std::vector<ScanDrawing>& drawings) {
  if (drawings.empty()) return;
  cover(drawings);
  std::vector<std::vector<PlacedScan>> placed(count_);
  for (const ScanDrawing& d : drawings)
    placed[d.map].push_back({d.map, bind_beams(*d.scan), match_pose(slam_pose(d.pose), rules_.match)});
  parallel_tasks(count_, threads_, [&](std::size_t i) PARLOC_SIMD_LOOP {
    const MarkTile mark{span_, touched_.data() + i * span_.size()};
    for (const PlacedScan& p : placed[i])
      for (std::size_t m = 0; m < p.scan.hits; ++m)
        walk_beam(drawn_beam(p.scan, m, p.pose, rules_.draw), mark);
  });
  Workers one;
  list_new_tiles(touched_.data(), count_, maps(), store_, fresh_);
  assign_tiles(fresh_, maps(), store_, one);
  std::fill(touched_.begin(), touched_.end(), std::uint8_t{0});
  parallel_tasks(count_, threads_, [&](std::size_t i) PARLOC_SIMD_LOOP {
    std::uint8_t* const touched = touched_.data() + i * span_.size();
    const TileMap map = view(i);
    for (const PlacedScan& p : placed[i]) {
      for (std::size_t m = 0; m < p.scan.hits; ++m) {
        const DrawnBeam b = drawn_beam(p.scan, m, p.pose, rules_.draw);
        walk_beam(b, DrawAndMark{{&b, map, {}}, {span_, touched}});
      }
      tidy_marked(map, touched);
    }
  });
}

TileMap DraftMaps::view(std::size_t map) const {
  const bool drawn = map < count_;
  return {drawn ? span_ : TileSpan{}, drawn ? table_.data() + map * span_.size() : nullptr, store_.pool()};
}

SlamCells DraftMaps::cells(std::size_t map) const {
  const TileMap drawn = view(map);
  return gather_cells(drawn.span, drawn.table, [&](const std::vector<std::uint32_t>& ids, Tile* to) {
    for (const std::uint32_t id : ids) *to++ = drawn.pool.at(id);
  });
}

}  // namespace parloc::cpu
