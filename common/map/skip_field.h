// How far a ray may jump from a cell: the distance field that the skipping caster reads
// (common/map/ray_cast.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace parloc {

/// Bytes after the last cell of a skip field, so that a 32-bit load at any cell stays inside the array.
inline constexpr std::size_t kSkipFieldTail = 4;

/// Chebyshev distance in cells from every cell to the nearest blocking cell or to the outside of the grid (a
/// cell on the border is 1 from outside), capped at 255; 0 on blocking cells. blocks: width * height,
/// row-major, nonzero blocks; width and height 1 to kMaxMapSide (map_limits.h), else Error{internal}. Returns
/// (width + 2) * (height + 2) + kSkipFieldTail bytes: the grid with a ring of zeros around it, row-major,
/// stride width + 2, cell (i, j) at (j + 1) * (width + 2) + (i + 1); then the tail, zeros. Exact, serial,
/// linear time (two-pass chamfer, Rosenfeld and Pfaltz 1968).
std::vector<std::uint8_t> skip_field(const std::uint8_t* blocks, std::int32_t width, std::int32_t height);

}  // namespace parloc
