#include "common/search/pose_rays.h"

#include <utility>

#include "common/filter/bind.h"
#include "common/filter/trace_beam.h"
#include "common/map/grid_map.h"
#include "common/map/rays/skip_field.h"

namespace parloc {

PoseRays::PoseRays(const GridMap& map, bool unknown_blocks) {
  if (!map.walls.empty()) walls_ = index_walls(map);
  const std::vector<std::uint8_t> blocks =
      map.walls.empty() ? blocking_cells(map, unknown_blocks) : std::move(walls_.blocks);
  skip_ = skip_field(blocks.data(), map.width, map.height, 0).lines;
  map_ = bind_ray_map(skip_.data(), {}, map, walls_.view());
}

void PoseRays::cast(const BeamTable& beams, const Pose& pose, std::vector<float>& expected_m) const {
  float x = static_cast<float>(pose.x_m), y = static_cast<float>(pose.y_m);
  float theta = static_cast<float>(pose.theta_rad);
  const RayTraceArgs rays =
      bind_rays({&x, &y, &theta, nullptr, nullptr, 1}, map_, bind_beams(beams), SensorConfig{});
  const RayOrigin origin = ray_origin(rays, 0);
  expected_m.resize(beams.count);
  for (std::size_t m = 0; m < beams.count; ++m) expected_m[m] = trace_beam(rays, origin, m);
}

float PoseRays::cast(float x_m, float y_m, float heading_rad, float range_max_m) const {
  const SinCos h = portable_sincos(heading_rad);
  RayTraceArgs rays;
  rays.map = map_;
  rays.beams.range_max_m = range_max_m;
  const float one = 1.0f, none = 0.0f;
  rays.beams.direction_x = &one, rays.beams.direction_y = &none;
  const float per_m = map_.inv_resolution;
  return trace_beam(rays, {x_m * per_m, y_m * per_m, h.cos, h.sin, x_m, y_m}, 0);
}

}  // namespace parloc
