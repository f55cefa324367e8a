// How far a ray may leap from a cell: the table that the skipping casters read (common/map/rays/ray_cast.h).
//
// Along its main axis, that of the larger component of its direction, a ray crosses one grid line after the
// other. The table says how many of these lines any ray that starts anywhere in the cell crosses before it
// can meet a blocking cell. It may know one number for all directions, or one for each of 32 sectors of them:
// in a corridor the latter leaps along, where the former sees walls on both sides.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/math/host_device.h"
#include "common/math/zeroed_vector.h"

namespace parloc {

/// Slopes that the sectors of an octant are cut into, at most: 8 octants, by the signs of dx and dy and by
/// which is the larger, each of them cut into equal intervals of the slope. Large maps have half as many.
inline constexpr std::int32_t kSlopes = 4;

/// Bytes after the last cell of a skip field, so that a 32-bit load at any cell stays inside the array.
inline constexpr std::size_t kSkipFieldTail = 4;

/// A table of kSlopes is at most so large, 4 M cells: 100 x 100 m at 5 cm.
inline constexpr std::size_t kMostFineBytes = std::size_t{128} << 20;

/// Octant of a direction: bit 0 to the left, bit 1 downwards, bit 2 steep (|dy| > |dx|).
PARLOC_HD std::int32_t octant_of(float dx, float dy) {
  const bool steep = __builtin_fabsf(dy) > __builtin_fabsf(dx);
  return (dx < 0.0f ? 1 : 0) + (dy < 0.0f ? 2 : 0) + (steep ? 4 : 0);
}

/// Sector of a direction that is not zero. `slope`: smaller component over the larger, absolute; a slope on
/// the edge of two sectors may be in either, the table is right for both.
PARLOC_HD std::int32_t sector_of(std::int32_t octant, float slope, std::int32_t slopes) {
  const std::int32_t part = static_cast<std::int32_t>(slope * static_cast<float>(slopes));
  return octant * slopes + (part < slopes ? part : slopes - 1);
}

/// How the table is laid out: what a ray needs to find its plane.
struct SkipPlanes {
  std::int32_t bytes = 0;   ///< From a sector's plane to the next; 0 if one plane serves all directions.
  std::int32_t slopes = 1;  ///< Sectors of an octant.
};

struct SkipField {
  /// By sector 8 * planes.slopes + 1 planes, the last of which has the least of the others, else one plane.
  /// Planes of (width + 2) x (height + 2) bytes: the grid with a ring of zeros around it, row-major, cell (i,
  /// j) at (j + 1) * (width + 2) + (i + 1); then the tail. 0 on blocking cells and the ring. Elsewhere the
  /// number of lines, 1 to 255; 1 promises nothing beyond the cell itself.
  ZeroedVector<std::uint8_t> lines;
  SkipPlanes planes;
};

/// blocks: width * height, row-major, nonzero blocks; width and height 1 to kMaxMapSide (map_limits.h), else
/// Error{internal}. By sector if that takes at most `most_bytes`, of kSlopes up to kMostFineBytes and of half
/// as many beyond; else one plane for all directions, from the Chebyshev distance to the nearest blocking
/// cell (two-pass chamfer, Rosenfeld and Pfaltz 1968). Linear time, on so many threads (0: all cores); the
/// same on every machine. std::bad_alloc.
SkipField skip_field(const std::uint8_t* blocks, std::int32_t width, std::int32_t height,
                     std::size_t most_bytes, int threads = 1);

}  // namespace parloc
