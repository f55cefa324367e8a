// One expected range: what ray_trace stores and the fused weight computes on the fly.
#pragma once

#include "common/filter/stages.h"

namespace parloc {

/// A particle ready for its rays: the sensor's place [cells], cosine and sine of the particle's heading.
struct RayOrigin {
  float u, v, c, s;
};

PARLOC_HD RayOrigin ray_origin(const RayTraceArgs& a, std::size_t particle) {
  const SinCos h = portable_sincos(a.particles.theta[particle]);
  const float x = base_to_grid_x(a.particles.x[particle], h.cos, h.sin, a.beams.sensor_x, a.beams.sensor_y);
  const float y = base_to_grid_y(a.particles.y[particle], h.cos, h.sin, a.beams.sensor_x, a.beams.sensor_y);
  return {x * a.map.inv_resolution, y * a.map.inv_resolution, h.cos, h.sin};
}

/// Whether no ray of the particle can meet a wall within the maximum range; false if that is not known.
PARLOC_HD bool nothing_in_reach(const RayTraceArgs& a, const RayOrigin& o) {
  if (!a.map.contains_point(o.u, o.v)) return false;
  const std::int32_t lines =
      a.map.free_lines_at(static_cast<std::int32_t>(o.u), static_cast<std::int32_t>(o.v));
  return static_cast<float>(lines - 1) > a.beams.range_max_m * a.map.inv_resolution;
}

/// Expected range [m] of one beam, at most range_max_m.
PARLOC_HD float trace_beam(const RayTraceArgs& a, const RayOrigin& o, std::size_t beam) {
  const float range_max_m = a.beams.range_max_m;
  const float reach_cells = range_max_m * a.map.inv_resolution;
  const Ray ray = beam_ray(o.u, o.v, o.c, o.s, a.beams.direction_x[beam], a.beams.direction_y[beam]);
  if (a.caster == RayCaster::fixed_step)
    return cast_fixed_step(a.map, ray, reach_cells, a.fixed_step_cells, range_max_m);
  const RayHit hit =
      a.caster == RayCaster::dda ? cast_dda(a.map, ray, reach_cells) : cast_skip(a.map, ray, reach_cells);
  return range_of_hit(ray, hit, a.map.resolution_m, range_max_m);
}

}  // namespace parloc
