// Exact squared Euclidean distance field in integers, one line at a time: the arithmetic that
// cpu/distance_field.cpp and cuda/distance_field.cu loop over (SPEC 7.1; Meijster, Roerdink and Hesselink
// 2000).
//
//   1. every column: the vertical distance g of each cell to the nearest source of its own column;
//   2. every row: E(i) = min over k of (i - k)^2 + g(k)^2, the lower envelope of parabolas.
//
// Cells are row-major, index j * width + i. Both sides are at most kMaxMapSide
// (map_limits.h), which keeps every term of pass 2 within 31 bits: 2 * 32766^2 < 2^31. Integers only, so the
// result is the same on every machine and for any schedule.
#pragma once

#include <cstdint>

#include "common/map/map_limits.h"
#include "common/math/host_device.h"

namespace parloc {

/// The squared distance where the map has no source at all [cells^2].
inline constexpr std::uint32_t kNoObstacle = 0xffffffffu;

/// Vertical distances from here up mean that the column has no source [cells].
inline constexpr std::uint32_t kNoSourceInColumn = 1u << 20;

/// Pass 1 on `columns` neighbouring columns at once (1 on a device, a strip of cache lines on a host).
/// `is_source` (nonzero: a source) and `distance` point at the strip's first cell of row 0; a row is `stride`
/// cells. Writes distance[j * stride + c] in cells for j in [0, height), c in [0, columns); >=
/// kNoSourceInColumn: none.
PARLOC_HD void column_distances(const std::uint8_t* is_source, std::uint32_t* distance, std::int32_t columns,
                                std::int32_t height, std::int64_t stride) {
  for (std::int32_t c = 0; c < columns; ++c) distance[c] = is_source[c] != 0 ? 0u : kNoSourceInColumn;
  for (std::int32_t j = 1; j < height; ++j) {
    const std::uint8_t* source = is_source + j * stride;
    const std::uint32_t* before = distance + (j - 1) * stride;
    std::uint32_t* here = distance + j * stride;
    for (std::int32_t c = 0; c < columns; ++c) here[c] = source[c] != 0 ? 0u : before[c] + 1u;
  }
  for (std::int32_t j = height - 2; j >= 0; --j) {
    const std::uint32_t* after = distance + (j + 1) * stride;
    std::uint32_t* here = distance + j * stride;
    for (std::int32_t c = 0; c < columns; ++c) here[c] = after[c] + 1u < here[c] ? after[c] + 1u : here[c];
  }
}

/// One parabola of the lower envelope of a row: it is the lowest from cell `begin` to the next one's begin.
struct RowParabola {
  std::int32_t begin;           // first cell [index]
  std::int32_t column;          // its source's column [index]
  std::int32_t height_squared;  // vertical distance to the source, squared [cells^2]
};

PARLOC_HD std::int32_t parabola_at(const RowParabola& p, std::int32_t i) {
  return (i - p.column) * (i - p.column) + p.height_squared;
}

/// First cell from which `right` is strictly lower than `left`. Precondition: left.column < right.column and
/// `left` is not higher at some cell >= 0, so that the quotient is not negative and truncation is floor.
PARLOC_HD std::int32_t takes_over_at(const RowParabola& left, const RowParabola& right) {
  const std::int32_t numerator = (right.column * right.column - left.column * left.column) +
                                 (right.height_squared - left.height_squared);
  const std::uint32_t divisor = 2u * static_cast<std::uint32_t>(right.column - left.column);
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(numerator) / divisor) + 1;
}

/// Pass 2 on one row, in place: vertical distances [cells] in, squared distances [cells^2] out; all
/// kNoObstacle if no column has a source. `scratch`: at least `width` parabolas, contents of no interest.
/// Linear in `width`.
PARLOC_HD void row_squared_distances(std::uint32_t* row, std::int32_t width, RowParabola* scratch) {
  std::int32_t count = 0;  // parabolas in the envelope
  for (std::int32_t i = 0; i < width; ++i) {
    if (row[i] >= kNoSourceInColumn) continue;
    const std::int32_t g = static_cast<std::int32_t>(row[i]);
    RowParabola next{0, i, g * g};
    while (count > 0 && parabola_at(scratch[count - 1], scratch[count - 1].begin) >
                            parabola_at(next, scratch[count - 1].begin))
      --count;
    if (count > 0) next.begin = takes_over_at(scratch[count - 1], next);
    if (next.begin < width) scratch[count++] = next;
  }
  if (count == 0) {
    for (std::int32_t i = 0; i < width; ++i) row[i] = kNoObstacle;
    return;
  }
  for (std::int32_t k = 0; k < count; ++k) {
    const RowParabola p = scratch[k];
    const std::int32_t end = k + 1 < count ? scratch[k + 1].begin : width;
    for (std::int32_t i = p.begin; i < end; ++i) row[i] = static_cast<std::uint32_t>(parabola_at(p, i));
  }
}

}  // namespace parloc
