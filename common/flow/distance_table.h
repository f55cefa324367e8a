// Distances to the nearest wall, by cell, laid out for interpolation: the values above each other side by
// side, and a ring around the map that repeats its edge, so that a point beyond the outermost cell centres
// has the edge's value and no slope (SPEC 7.1, 7.2). Between the cell centres: value and slope of the same
// polynomial.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/math/host_device.h"
#include "common/math/portable.h"

namespace parloc {

/// Of a cell and of the one above it [cells].
struct DistancePair {
  float here, above;
};

/// Farther than any cap: what is off the map.
constexpr float kOffMapCells = 1e6f;

/// Where an end point falls: the table's entry to the lower left of it, and how far it is beyond that
/// [cells].
struct TablePlace {
  std::int32_t at;
  float right, up;  ///< In [0, 1].
};

/// Entries of the table: (height + 2) rows of (width + 2), then two that are off the map.
constexpr std::size_t distance_table_size(std::int32_t width, std::int32_t height) {
  return (static_cast<std::size_t>(width) + 2) * (static_cast<std::size_t>(height) + 2) + 2;
}

struct DistanceTable {
  const DistancePair* entries = nullptr;
  std::int32_t width = 0;   ///< Of the map [cells].
  std::int32_t height = 0;  ///< [cells]

  PARLOC_HD std::int32_t stride() const { return width + 2; }
  PARLOC_HD std::int32_t off_map() const { return stride() * (height + 2); }

  /// Of a point in cells, counted from the centre of cell (0, 0). NaN is off the map.
  PARLOC_HD TablePlace place(float u, float v) const {
    const float last_u = static_cast<float>(width - 1), last_v = static_cast<float>(height - 1);
    const bool on_map = u >= -0.5f && v >= -0.5f && u < last_u + 0.5f && v < last_v + 0.5f;
    const float uc = min_of(max_of(u, -1.0f), last_u);
    const float vc = min_of(max_of(v, -1.0f), last_v);
    const float i = floor_of(uc), j = floor_of(vc);
    const std::int32_t at = (static_cast<std::int32_t>(j) + 1) * stride() + static_cast<std::int32_t>(i) + 1;
    return {on_map ? at : off_map(), uc - i, vc - j};
  }

  /// Of a cell of the map, or of the nearest one [cells].
  PARLOC_HD float at_cell(std::int32_t i, std::int32_t j) const {
    const std::int32_t ic = i < 0 ? 0 : (i < width ? i : width - 1);
    const std::int32_t jc = j < 0 ? 0 : (j < height ? j : height - 1);
    return entries[(jc + 1) * stride() + ic + 1].here;
  }
};

/// Distance of the map's cell that entry `at` repeats; squared_cells: width x height, row-major [cells^2].
PARLOC_HD float table_distance(const std::uint32_t* squared_cells, std::int32_t width, std::int32_t height,
                               std::int64_t i, std::int64_t j) {
  const std::int64_t ic = i < 0 ? 0 : (i < width ? i : width - 1);
  const std::int64_t jc = j < 0 ? 0 : (j < height ? j : height - 1);
  return static_cast<float>(__builtin_sqrt(static_cast<double>(squared_cells[jc * width + ic])));
}

/// Entry `at` of the table.
PARLOC_HD DistancePair table_pair(const std::uint32_t* squared_cells, std::int32_t width, std::int32_t height,
                                  std::size_t at) {
  const std::size_t stride = static_cast<std::size_t>(width) + 2;
  if (at >= distance_table_size(width, height) - 2) return {kOffMapCells, kOffMapCells};
  const std::int64_t i = static_cast<std::int64_t>(at % stride) - 1;
  const std::int64_t j = static_cast<std::int64_t>(at / stride) - 1;
  return {table_distance(squared_cells, width, height, i, j),
          table_distance(squared_cells, width, height, i, j + 1)};
}

/// Distance [cells] and its slope, which has no unit.
struct FieldValue {
  float distance, slope_x, slope_y;
  float within_reach = 1.0f;  ///< 0 from the cap on.
};

/// Between four cell centres.
PARLOC_HD FieldValue bilinear_patch(const DistancePair& left, const DistancePair& right, float fx, float fy) {
  const float low_slope = right.here - left.here, high_slope = right.above - left.above;
  const float low = fused(fx, low_slope, left.here), high = fused(fx, high_slope, left.above);
  const float rise = high - low;
  return {fused(fy, rise, low), fused(fy, high_slope - low_slope, low_slope), rise};
}

/// From the cap on a point is far from every wall, and pulls nowhere. Below 0 the slope is kept: a cubic
/// patch overshoots near corners.
PARLOC_HD FieldValue capped(const FieldValue& f, float cap_cells) {
  const bool far = !(f.distance < cap_cells);
  const float value = max_of(f.distance, 0.0f);
  return {far ? cap_cells : value, far ? 0.0f : f.slope_x, far ? 0.0f : f.slope_y, far ? 0.0f : 1.0f};
}

/// Weights of four samples at -1, 0, 1, 2, and their derivatives, at f in [0, 1].
struct CatmullRom {
  float w[4], d[4];
};
PARLOC_HD CatmullRom catmull_rom(float f) {
  CatmullRom c;
  c.w[0] = 0.5f * f * fused(f, 2.0f - f, -1.0f);
  c.w[1] = fused(0.5f * f * f, fused(3.0f, f, -5.0f), 1.0f);
  c.w[2] = 0.5f * f * fused(f, fused(-3.0f, f, 4.0f), 1.0f);
  c.w[3] = 0.5f * f * f * (f - 1.0f);
  c.d[0] = 0.5f * fused(f, fused(-3.0f, f, 4.0f), -1.0f);
  c.d[1] = 0.5f * f * fused(9.0f, f, -10.0f);
  c.d[2] = 0.5f * fused(f, fused(-9.0f, f, 8.0f), 1.0f);
  c.d[3] = 0.5f * f * fused(3.0f, f, -2.0f);
  return c;
}

/// Of a point in cells from the centre of cell (0, 0): an interpolating cubic over 4 x 4 cells.
PARLOC_HD FieldValue cubic_patch(const DistanceTable& t, float u, float v) {
  const float last_u = static_cast<float>(t.width - 1), last_v = static_cast<float>(t.height - 1);
  if (!(u >= -0.5f && v >= -0.5f && u < last_u + 0.5f && v < last_v + 0.5f))
    return {kOffMapCells, 0.0f, 0.0f};
  const float i = max_of(min_of(floor_of(u), last_u - 1.0f), 0.0f);
  const float j = max_of(min_of(floor_of(v), last_v - 1.0f), 0.0f);
  const CatmullRom cx = catmull_rom(min_of(max_of(u - i, 0.0f), 1.0f));
  const CatmullRom cy = catmull_rom(min_of(max_of(v - j, 0.0f), 1.0f));
  FieldValue sum{0.0f, 0.0f, 0.0f};
  for (int b = 0; b < 4; ++b) {
    float row = 0.0f, row_slope = 0.0f;
    for (int a = 0; a < 4; ++a) {
      const float d = t.at_cell(static_cast<std::int32_t>(i) + a - 1, static_cast<std::int32_t>(j) + b - 1);
      row = fused(cx.w[a], d, row);
      row_slope = fused(cx.d[a], d, row_slope);
    }
    sum.distance = fused(cy.w[b], row, sum.distance);
    sum.slope_x = fused(cy.w[b], row_slope, sum.slope_x);
    sum.slope_y = fused(cy.d[b], row, sum.slope_y);
  }
  if (u < 0.0f || u > last_u) sum.slope_x = 0.0f;  // a coordinate beyond the centres is the edge's
  if (v < 0.0f || v > last_v) sum.slope_y = 0.0f;
  return sum;
}

}  // namespace parloc
