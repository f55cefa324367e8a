// Beam skipping as in nav2's AMCL (likelihood_field_prob): a beam that few particles agree with has met
// something that is not on the map, and is left out for all of them.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/portable.h"
#include "common/model/sensor_config.h"

namespace parloc {

struct BeamSkip {
  const std::uint32_t* squared_cells = nullptr;  ///< To the nearest wall, width x height, row-major.
  std::int32_t width = 0, height = 0;
  std::uint32_t agree_below = 0;  ///< [cells^2]
  double threshold = 0, error_threshold = 0;
  double spread_m = 0;

  /// Whether the end point (u, v) [cells] is near a wall. None is off the map.
  PARLOC_HD bool agrees(float u, float v) const {
    const float cu = floor_of(min_of(max_of(u, -1.0f), static_cast<float>(width)));
    const float cv = floor_of(min_of(max_of(v, -1.0f), static_cast<float>(height)));
    const std::int32_t i = static_cast<std::int32_t>(cu), j = static_cast<std::int32_t>(cv);
    const bool on_map = i >= 0 && i < width && j >= 0 && j < height;
    const std::size_t at =
        static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i);
    return on_map && squared_cells[at] < agree_below;
  }
};

/// `squared_cells` in the backend's memory; null for models that do not skip.
inline BeamSkip bind_beam_skip(const SensorConfig& c, const std::uint32_t* squared_cells, std::int32_t width,
                               std::int32_t height, double resolution_m) {
  const double cells = c.beam_skip_distance / resolution_m;
  const double below = std::ceil(cells * cells);
  return {squared_cells,
          width,
          height,
          below < 4294967295.0 ? static_cast<std::uint32_t>(below) : 4294967295u,
          c.beam_skip_threshold,
          c.beam_skip_error_threshold,
          c.beam_skip_spread};
}

}  // namespace parloc
