// How a scan is written into a map: what each beam adds to the cells on its way (SPEC 9.5).
#pragma once

#include <cstdint>

#include "common/map/rays/ray_cast.h"
#include "common/math/atomics.h"
#include "common/slam/matching/match_beam.h"

namespace parloc {

/// The cells that a beam passes (Amanatides and Woo 1987; SPEC 2.2): as many steps along each axis as its
/// ends are apart, so that it ends in the cell of its end point.
class CellWalk {
 public:
  /// From (u0, v0) to (u1, v1) [cells].
  PARLOC_HD CellWalk(float u0, float v0, float u1, float v1)
      : ray_(make_ray(u0, v0, u1 - u0, v1 - v0)),
        i_(static_cast<std::int32_t>(floor_of(u0))),
        j_(static_cast<std::int32_t>(floor_of(v0))) {
    const std::int32_t di = static_cast<std::int32_t>(floor_of(u1)) - i_;
    const std::int32_t dj = static_cast<std::int32_t>(floor_of(v1)) - j_;
    step_i_ = di < 0 ? -1 : 1, step_j_ = dj < 0 ? -1 : 1;
    left_i_ = di < 0 ? -di : di, left_j_ = dj < 0 ? -dj : dj;
  }
  PARLOC_HD std::int32_t i() const { return i_; }
  PARLOC_HD std::int32_t j() const { return j_; }
  /// This is the last cell.
  PARLOC_HD bool at_end() const { return left_i_ + left_j_ == 0; }
  PARLOC_HD void step() {
    const float ti = (static_cast<float>(step_i_ < 0 ? i_ : i_ + 1) - ray_.u) * ray_.inv_dx;
    const float tj = (static_cast<float>(step_j_ < 0 ? j_ : j_ + 1) - ray_.v) * ray_.inv_dy;
    const bool along_i = left_j_ == 0 || (left_i_ > 0 && ti < tj);
    i_ += along_i ? step_i_ : 0, left_i_ -= along_i ? 1 : 0;
    j_ += along_i ? 0 : step_j_, left_j_ -= along_i ? 0 : 1;
  }

 private:
  Ray ray_;
  std::int32_t i_, j_, step_i_, step_j_, left_i_, left_j_;
};

/// How a scan is written into a map.
struct DrawRules {
  float inv_resolution = 0;  ///< [cells/m]
  float usable_cells = 0;    ///< Beams are cut here.
  float clear_cells = 0;     ///< So far a beam that saw nothing clears its way; 0: it is not drawn.
};

/// The first so many beams of a scan are drawn: those that hit something, or all.
PARLOC_HD std::size_t drawn_beams(const Beams& b, const DrawRules& r) {
  return r.clear_cells > 0 ? b.count : b.hits;
}

/// A beam on its way from the sensor: map frame, cells.
struct DrawnBeam {
  float u0, v0, u1, v1;
  bool hit;  ///< It ends at (u1, v1); else it goes on.
};
PARLOC_HD DrawnBeam drawn_beam(const Beams& b, std::size_t m, const MatchPose& p, const DrawRules& r) {
  const float ox = b.origin_x[m] * r.inv_resolution, oy = b.origin_y[m] * r.inv_resolution;
  const float range = b.range_m[m] * r.inv_resolution;
  const bool miss = m >= b.hits;
  const float most = miss && r.clear_cells < r.usable_cells ? r.clear_cells : r.usable_cells;
  const bool hit = !miss && range <= most;
  const float reach = range <= most ? range : most;
  const float ex = hit ? b.end_x[m] : fused(reach, b.direction_x[m], ox);
  const float ey = hit ? b.end_y[m] : fused(reach, b.direction_y[m], oy);
  DrawnBeam d;
  d.u0 = fused(p.cos, ox, fused(-p.sin, oy, p.u)), d.v0 = fused(p.sin, ox, fused(p.cos, oy, p.v));
  d.u1 = fused(p.cos, ex, fused(-p.sin, ey, p.u)), d.v1 = fused(p.sin, ex, fused(p.cos, ey, p.v));
  d.hit = hit;
  return d;
}

/// Calls visit(i, j, last) for each cell that a beam comes to.
template <class Visit>
PARLOC_HD void walk_beam(const DrawnBeam& b, Visit visit) {
  CellWalk walk(b.u0, b.v0, b.u1, b.v1);
  while (!walk.at_end()) {
    visit(walk.i(), walk.j(), false);
    walk.step();
  }
  visit(walk.i(), walk.j(), true);
}

/// The tile that a beam is in, so that only where it comes to another one anything is looked up.
class TileOfBeam {
 public:
  /// Whether cell (i, j) is in another tile than the cell before.
  PARLOC_HD bool moves_to(std::int32_t i, std::int32_t j) {
    const std::int32_t ti = i >> kTileShift, tj = j >> kTileShift;
    const bool moves = is_first_ || ti != i_ || tj != j_;
    is_first_ = false, i_ = ti, j_ = tj;
    return moves;
  }

 private:
  bool is_first_ = true;
  std::int32_t i_ = 0, j_ = 0;
};

/// Notes which tiles a beam comes to. touched: [span.size()]
struct MarkTile {
  TileSpan span;
  std::uint8_t* touched;
  TileOfBeam tile = {};
  PARLOC_HD void operator()(std::int32_t i, std::int32_t j, bool) {
    if (!tile.moves_to(i, j)) return;
    const std::size_t at = span.place(i, j);
    if (at < span.size()) atomic_write(&touched[at], std::uint8_t{1});
  }
};

/// Counts a beam in the cells that it comes to. `Add`: adds to a word, atomically where beams are drawn side
/// by side.
template <class Add>
struct DrawCell {
  const DrawnBeam* beam;
  TileMap map;
  Add add;
  TileOfBeam tile = {};
  CellWord* cells = nullptr;  ///< Of that tile; null beyond the span.
  PARLOC_HD void operator()(std::int32_t i, std::int32_t j, bool last) {
    if (tile.moves_to(i, j)) {
      const std::size_t at = map.span.place(i, j);
      cells = at < map.span.size() ? map.pool.at(map.table[at]).cell : nullptr;
    }
    if (cells == nullptr) return;
    CellWord* const word = cells + cell_in_tile(i, j);
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
