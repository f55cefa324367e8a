// One expected range: what ray_trace stores and the fused weight computes on the fly.
#pragma once

#include "common/filter/stages.h"
#include "common/map/rays/wall_cast.h"

namespace parloc {

/// A particle ready for its rays: where its first beam starts [cells], cosine and sine of its heading, its
/// own place [m].
struct RayOrigin {
  float u, v, c, s;
  float x_m, y_m;
};

PARLOC_HD RayOrigin ray_origin(const RayTraceArgs& a, std::size_t particle) {
  const SinCos h = portable_sincos(a.particles.theta[particle]);
  const float x_m = a.particles.x[particle], y_m = a.particles.y[particle];
  const float first_x_m = base_to_grid_x(x_m, h.cos, h.sin, a.beams.first_origin_x, a.beams.first_origin_y);
  const float first_y_m = base_to_grid_y(y_m, h.cos, h.sin, a.beams.first_origin_x, a.beams.first_origin_y);
  return {first_x_m * a.map.inv_resolution, first_y_m * a.map.inv_resolution, h.cos, h.sin, x_m, y_m};
}

PARLOC_HD Ray ray_of_beam(const RayTraceArgs& a, const RayOrigin& o, std::size_t beam) {
  const Beams& b = a.beams;
  float u = o.u, v = o.v;
  if (b.origin_spread_m > 0.0f) {
    u = base_to_grid_x(o.x_m, o.c, o.s, b.origin_x[beam], b.origin_y[beam]) * a.map.inv_resolution;
    v = base_to_grid_y(o.y_m, o.c, o.s, b.origin_x[beam], b.origin_y[beam]) * a.map.inv_resolution;
  }
  return beam_ray(u, v, o.c, o.s, b.direction_x[beam], b.direction_y[beam]);
}

/// Whether all beams of the particle start inside the grid; false if that is not known.
PARLOC_HD bool starts_inside(const RayTraceArgs& a, const RayOrigin& o) {
  if (a.beams.origin_spread_m == 0.0f) return a.map.contains_point(o.u, o.v);
  const float u = o.x_m * a.map.inv_resolution, v = o.y_m * a.map.inv_resolution;
  const float reach_cells = a.beams.origin_reach_m * a.map.inv_resolution + 1.0f;
  return a.map.contains_point(u - reach_cells, v - reach_cells) &&
         a.map.contains_point(u + reach_cells, v + reach_cells);
}

/// Whether no ray of the particle can meet a wall within the maximum range; false if that is not known.
PARLOC_HD bool nothing_in_reach(const RayTraceArgs& a, const RayOrigin& o) {
  if (!a.map.contains_point(o.u, o.v)) return false;
  const std::int32_t lines =
      a.map.free_lines_at(static_cast<std::int32_t>(o.u), static_cast<std::int32_t>(o.v));
  const float reach_m = a.beams.range_max_m + a.beams.origin_spread_m;
  return static_cast<float>(lines - 1) > reach_m * a.map.inv_resolution;
}

/// Expected range [m] of one beam, at most range_max_m.
PARLOC_HD float trace_beam(const RayTraceArgs& a, const RayOrigin& o, std::size_t beam) {
  const float range_max_m = a.beams.range_max_m;
  const float reach_cells = range_max_m * a.map.inv_resolution;
  const Ray ray = ray_of_beam(a, o, beam);
  if (a.caster == RayCaster::fixed_step)
    return cast_fixed_step(a.map, ray, reach_cells, a.fixed_step_cells, range_max_m);
  if (a.map.walls.count > 0) {
    const float t = a.caster == RayCaster::dda ? cast_all_walls(a.map, ray, reach_cells)
                                               : cast_walls(a.map, ray, reach_cells);
    return range_of_wall(t, a.map.resolution_m, range_max_m);
  }
  if (a.caster == RayCaster::skip) return range_by_skip(a.map, ray, reach_cells, range_max_m);
  return range_of_hit(ray, cast_dda(a.map, ray, reach_cells), a.map.resolution_m, range_max_m);
}

}  // namespace parloc
