// What the CUDA backend makes of a map on the host, once, before it goes down to the device.
#pragma once

#include <cstdint>
#include <vector>

#include "common/map/blocking_cells.h"
#include "common/map/distance_field.h"
#include "common/map/skip_field.h"
#include "cuda/launch.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

inline std::vector<std::uint8_t> skip_field_of(const GridMap& map, bool unknown_blocks) {
  const std::vector<std::uint8_t> blocks = blocking_cells(map, unknown_blocks);
  return skip_field(blocks.data(), map.width, map.height);
}

/// Squared distance in cells to the nearest occupied cell; the same passes as cpu/distance_field.cpp, serial.
inline std::vector<std::uint32_t> squared_distance_of(const GridMap& map) {
  const std::vector<std::uint8_t> occupied = blocking_cells(map, false);
  std::vector<std::uint32_t> field(map.size());
  column_distances(occupied.data(), field.data(), map.width, map.height, map.width);
  std::vector<RowParabola> scratch(static_cast<std::size_t>(map.width));
  for (std::int32_t j = 0; j < map.height; ++j)
    row_squared_distances(field.data() + static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width),
                          map.width, scratch.data());
  return field;
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
