// How a scan is written into a map: what each beam adds to the cells on its way (SPEC 9.5).
#pragma once

#include "common/slam/cell_walk.h"
#include "common/slam/slam_stages.h"

namespace parloc {

/// Calls visit(i, j, last) for each cell that a beam comes to.
template <class Visit>
PARLOC_HD void walk_beam(const DrawnBeam& b, const Visit& visit) {
  CellWalk walk(b.u0, b.v0, b.u1, b.v1);
  while (!walk.at_end()) {
    visit(walk.i(), walk.j(), false);
    walk.step();
  }
  visit(walk.i(), walk.j(), true);
}

/// Notes which tiles a beam comes to. touched: [span.size()]
struct MarkTile {
  TileSpan span;
  std::uint8_t* touched;
  PARLOC_HD void operator()(std::int32_t i, std::int32_t j, bool) const {
    const std::size_t at = span.place(i, j);
    if (at < span.size()) touched[at] = 1;  // whoever writes, it is 1
  }
};

/// Counts a beam in the cells that it comes to. `Add`: adds to a word, atomically where beams are drawn side
/// by side.
template <class Add>
struct DrawCell {
  const DrawnBeam* beam;
  TileMap map;
  Add add;
  PARLOC_HD void operator()(std::int32_t i, std::int32_t j, bool last) const {
    const std::size_t at = map.span.place(i, j);
    if (at >= map.span.size()) return;
    CellWord* word = map.pool.at(map.table[at]).cell + cell_in_tile(i, j);
    if (last && beam->hit)
      add(word, ended_at(beam->u1 - floor_of(beam->u1), beam->v1 - floor_of(beam->v1)));
    else
      add(word, kPassed);
  }
};

/// Where nobody else draws at the same time.
struct PlainAdd {
  PARLOC_HD void operator()(CellWord* at, CellWord more) const { *at += more; }
};

/// After a scan: counts kept within their limits, and the bits of a row made anew.
PARLOC_HD void tidy_row(Tile& tile, std::int32_t j) {
  std::uint32_t row = 0;
  for (std::int32_t i = 0; i < kTileCells; ++i) {
    CellWord& w = tile.cell[j * kTileCells + i];
    w = aged(w);
    row |= static_cast<std::uint32_t>(is_occupied(w)) << i;
  }
  tile.occupied[j] = row;
}

}  // namespace parloc
