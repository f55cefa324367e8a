#include "common/model/likelihood_field.h"

namespace parloc {

float field_log_likelihood(std::uint32_t squared_cells, double resolution_m, double range_max_m,
                           const SensorConfig& c) {
  const double cap_m = c.laser_likelihood_max_dist;
  const double squared_m = resolution_m * resolution_m * static_cast<double>(squared_cells);
  const double squared_capped = squared_m < cap_m * cap_m ? squared_m : cap_m * cap_m;
  const float peak = static_cast<float>(c.z_hit * 0.39894228040143267794 / c.sigma_hit);
  const float floor = static_cast<float>(c.z_rand / range_max_m);
  const float exponent = static_cast<float>(-0.5 * squared_capped / (c.sigma_hit * c.sigma_hit));
  return portable_log(fused(peak, portable_exp(exponent), floor)) - portable_log(peak + floor);
}

std::vector<float> likelihood_table(const std::vector<std::uint32_t>& squared_cells, const GridMap& map,
                                    double range_max_m, const SensorConfig& config) {
  const double cap_cells = config.laser_likelihood_max_dist / map.resolution_m;
  const double cap_entries = cap_cells * cap_cells + 2.0;
  const std::uint32_t entries = static_cast<std::uint32_t>(cap_entries < 1e6 ? cap_entries : 1e6);
  std::vector<float> by_distance(entries);
  for (std::uint32_t e = 0; e < entries; ++e)
    by_distance[e] = field_log_likelihood(e, map.resolution_m, range_max_m, config);

  const std::size_t stride = static_cast<std::size_t>(map.width) + 2;
  const float off_map = by_distance.back();
  std::vector<float> table(stride * (static_cast<std::size_t>(map.height) + 2), off_map);
  for (std::int32_t j = 0; j < map.height; ++j) {
    const std::uint32_t* row = squared_cells.data() + static_cast<std::size_t>(j) * map.width;
    float* out = table.data() + (static_cast<std::size_t>(j) + 1) * stride + 1;
    for (std::int32_t i = 0; i < map.width; ++i) out[i] = row[i] < entries ? by_distance[row[i]] : off_map;
  }
  return table;
}

}  // namespace parloc
