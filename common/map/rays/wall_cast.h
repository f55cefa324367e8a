// Rays against walls that are segments: where the nearest one is hit. wall_hit *defines* the range; trying
// all walls (cast_all_walls, the OpenCL particle filter's way) and looking into the cells that the ray passes
// (cast_walls) give the identical float. Units: cells, as in ray_cast.h.
#pragma once

#include <cstdint>

#include "common/map/rays/ray_cast.h"

namespace parloc {

/// Share of a length that float32 arithmetic with it may err by, generously.
inline constexpr float kWallSlack = 1e-6f;

inline constexpr float kNoWall = __builtin_inff();

PARLOC_HD float cross(float ax, float ay, float bx, float by) {
  return fused(ax, by, -(ay * bx));
}
PARLOC_HD float dot(float ax, float ay, float bx, float by) {
  return fused(ax, bx, ay * by);
}

/// Distance along the ray to the wall, kNoWall if it passes by or the wall is behind. The hit is the point of
/// the wall nearest to where its line meets the ray's, if the ray passes it no farther than rounding can err:
/// so it is always on the wall, and a ray through the common end of two walls does not slip between them. A
/// ray along a wall hits its nearer end, or is at distance 0 if it starts within.
PARLOC_HD float wall_hit(const Ray& r, const RayWall& w) {
  const float x = w.ax - r.u, y = w.ay - r.v;
  const float slack = kWallSlack * max_of(max_of(__builtin_fabsf(x), __builtin_fabsf(y)), 1.0f);
  const float det = cross(r.dx, r.dy, w.ex, w.ey);  // the wall's extent across the ray
  const float off = cross(x, y, r.dx, r.dy);        // how far across the ray its start is
  const float start = dot(x, y, r.dx, r.dy), extent = dot(w.ex, w.ey, r.dx, r.dy);  // the same along the ray
  const float size = __builtin_fabsf(det);
  const float across = det < 0.0f ? -off : off;
  const bool passes = across >= -slack && across <= size + slack;
  const float share = min_of(max_of(off / det, 0.0f), 1.0f);
  const float crossing = fused(share, extent, start);
  const float end = start + extent;
  const bool within = min_of(start, end) <= 0.0f && max_of(start, end) >= 0.0f;
  const float along = within ? 0.0f : min_of(start, end);
  const bool parallel = size <= kWallSlack * (__builtin_fabsf(w.ex) + __builtin_fabsf(w.ey));
  const float t = parallel ? along : crossing;
  return passes && t >= 0.0f ? t : kNoWall;
}

/// The reference: every wall.
PARLOC_HD float cast_all_walls(const RayMap& m, const Ray& r, float reach_cells) {
  float nearest = kNoWall;
  for (std::uint32_t k = 0; k < m.walls.count; ++k) nearest = min_of(wall_hit(r, m.walls.wall[k]), nearest);
  return nearest < reach_cells ? nearest : kNoWall;
}

PARLOC_HD float nearest_in_cell(const RayMap& m, const Ray& r, std::int32_t i, std::int32_t j) {
  const std::int64_t cell = static_cast<std::int64_t>(j) * m.width + i;
  float nearest = kNoWall;
  for (std::uint32_t k = m.walls.first[cell]; k < m.walls.first[cell + 1]; ++k)
    nearest = min_of(wall_hit(r, m.walls.wall[m.walls.id[k]]), nearest);
  return nearest;
}

/// Looks for the nearest wall in a cell that the ray passes. True if that settles the ray: `t` is the
/// distance, or kNoWall if there is none within reach. False if the ray goes on: `at` is then the next cell.
PARLOC_HD bool look_in_cell(const RayMap& m, const Ray& r, float reach_cells, RayStart& at, float& t) {
  const float nearest = nearest_in_cell(m, r, at.i, at.j);
  const float tx = (static_cast<float>(at.i + (r.dx < 0.0f ? 0 : 1)) - r.u) * r.inv_dx;
  const float ty = (static_cast<float>(at.j + (r.dy < 0.0f ? 0 : 1)) - r.v) * r.inv_dy;
  const bool step_x = tx < ty;  // as cast_dda
  const float leaves = step_x ? tx : ty;
  t = nearest <= leaves && nearest < reach_cells ? nearest : kNoWall;
  if (nearest <= leaves || !(leaves < reach_cells)) return true;
  at.i += step_x ? (r.dx < 0.0f ? -1 : 1) : 0;
  at.j += step_x ? 0 : (r.dy < 0.0f ? -1 : 1);
  at.inside = m.contains(at.i, at.j);
  return !at.inside;
}

/// Only the walls of cells that the ray passes, up to the first cell that it does not leave before the hit. A
/// hit is on its wall and, but for rounding, on the ray, so its cell or one next to it within rounding is
/// passed; walls are listed with more margin than that (wall_index.h).
PARLOC_HD float cast_walls(const RayMap& m, const Ray& r, float reach_cells) {
  RayStart at = start_cell(m, r, reach_cells);
  while (at.inside) {
    const RayHit cell = skip_from(m, r, at, reach_cells);
    if (!cell.hit) return kNoWall;
    at.i = cell.i, at.j = cell.j;
    float t = kNoWall;
    if (look_in_cell(m, r, reach_cells, at, t)) return t;
  }
  return kNoWall;
}

/// Distance along the ray [cells] -> range in metres, at most range_max_m.
PARLOC_HD float range_of_wall(float t, float resolution_m, float range_max_m) {
  return min_of(t * resolution_m, range_max_m);
}

}  // namespace parloc
