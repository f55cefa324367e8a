// The distance field between the cell centres: value and slope of the same polynomial (SPEC 7.2).
#pragma once

#include <cstdint>

#include "common/flow/distance_table.h"

namespace parloc {

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
