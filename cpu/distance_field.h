// The exact squared Euclidean distance field of a whole map, with OpenMP.
#pragma once

#include <cstdint>
#include <vector>

namespace parloc::cpu {

/// E[j * width + i]: squared distance in cells from cell (i, j) to the nearest cell whose `is_source` is not
/// zero, centre to centre; kNoObstacle (common/map/distance_field.h) everywhere if there is none. is_source:
/// width * height, row-major; width and height 1 to kMaxMapSide (common/map/map_limits.h); threads at least
/// 1, else Error{internal}. Exact, in integers: the same for any number of threads and on any machine. Linear
/// time; memory beside the input is the result (4 bytes per cell) and 12 bytes per column and thread.
std::vector<std::uint32_t> squared_distance_field(const std::uint8_t* is_source, std::int32_t width,
                                                  std::int32_t height, int threads);

}  // namespace parloc::cpu
