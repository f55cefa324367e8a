// One expected range on one thread: shared by ray_trace and the fused weight.
#pragma once

#include "common/filter/stages.h"
#include "cuda/launch.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

struct Origin {
  float u, v, c, s;  // sensor place [cells] and the particle's heading
};

PARLOC_HD Origin sensor_origin(const Particles& p, const Beams& b, const RayMap& map, std::size_t i) {
  const SinCos h = portable_sincos(p.theta[i]);
  const float x = base_to_grid_x(p.x[i], h.cos, h.sin, b.sensor_x, b.sensor_y);
  const float y = base_to_grid_y(p.y[i], h.cos, h.sin, b.sensor_x, b.sensor_y);
  return {x * map.inv_resolution, y * map.inv_resolution, h.cos, h.sin};
}

PARLOC_HD float trace_beam(const RayMap& map, const Beams& b, RayCaster caster, float step_cells,
                           const Origin& o, std::size_t m) {
  const float reach_cells = b.range_max_m * map.inv_resolution;
  const Ray ray = beam_ray(o.u, o.v, o.c, o.s, b.direction_x[m], b.direction_y[m]);
  if (caster == RayCaster::fixed_step)
    return cast_fixed_step(map, ray, reach_cells, step_cells, b.range_max_m);
  const RayHit hit =
      caster == RayCaster::dda ? cast_dda(map, ray, reach_cells) : cast_skip(map, ray, reach_cells);
  return range_of_hit(ray, hit, map.resolution_m, b.range_max_m);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
