// THE STAGES OF GRID SLAM, under the same names in cpu/ and cuda/. Poses are in the map frame, whose origin
// is where the robot started; cells are counted from there.
//
// clang-format off
// | stage          | reads                                     | writes                                                     |
// |----------------|-------------------------------------------|------------------------------------------------------------|
// | propose        | poses, maps, scan, motion                 | poses, log_weight, likelihood                              |
// | normalise_scan | log_weight                                | weights, N_eff, resample (common/filter/stages.h)          |
// | resample       | poses, weights                            | ancestor, the other pose buffer (likewise)                 |
// | inherit_tiles  | ancestor, tables, likelihood              | the other tables, likelihood; references                   |
// | mark_tiles     | poses, scan                               | touched: tiles that the scan will write                    |
// | find_new_tiles | touched, tables, references               | which of them a particle has to itself not yet             |
// | assign_tiles   | touched, tables, references               | tables: a tile of its own wherever a particle will write   |
// | register_scan  | poses, scan, touched, tables              | cells; occupied bits of the touched tiles                  |
// clang-format on
#pragma once

#include "common/slam/propose.h"

namespace parloc {

/// The maps of all particles in the backend's memory.
struct SlamMaps {
  TileSpan span;
  std::uint32_t* table = nullptr;  ///< [N][span.size()]
  TilePool pool;

  PARLOC_HD TileMap of(std::size_t particle) const { return {span, table + particle * span.size(), pool}; }
};

/// How a scan is written into a map.
struct DrawRules {
  float inv_resolution = 0;  ///< [cells/m]
  float usable_cells = 0;    ///< Beams are cut here.
};

/// Of all stages, so much as they need.
struct SlamArgs {
  ProposeRules rules;
  DrawRules draw;
  Beams beams;
  SlamMaps maps;
  Particles particles;
  float* likelihood = nullptr;      ///< [N] Sum of log-weights over the whole way.
  std::uint8_t* touched = nullptr;  ///< [N][span.size()] 1: the scan comes there.
};

/// A beam on its way from the sensor: map frame, cells.
struct DrawnBeam {
  float u0, v0, u1, v1;
  bool hit;  ///< It ends at (u1, v1); else it goes on.
};
PARLOC_HD DrawnBeam drawn_beam(const Beams& b, std::size_t m, const MatchPose& p, const DrawRules& r) {
  const float ox = b.origin_x[m] * r.inv_resolution, oy = b.origin_y[m] * r.inv_resolution;
  const float range = b.range_m[m] * r.inv_resolution;
  const bool hit = range <= r.usable_cells;
  const float reach = hit ? range : r.usable_cells;
  const float ex = hit ? b.end_x[m] : fused(reach, b.direction_x[m], ox);
  const float ey = hit ? b.end_y[m] : fused(reach, b.direction_y[m], oy);
  DrawnBeam d;
  d.u0 = fused(p.cos, ox, fused(-p.sin, oy, p.u)), d.v0 = fused(p.sin, ox, fused(p.cos, oy, p.v));
  d.u1 = fused(p.cos, ex, fused(-p.sin, ey, p.u)), d.v1 = fused(p.sin, ex, fused(p.cos, ey, p.v));
  d.hit = hit;
  return d;
}

PARLOC_HD SlamPose slam_pose(const Particles& p, std::size_t i) {
  return {p.x[i], p.y[i], p.theta[i]};
}

}  // namespace parloc
