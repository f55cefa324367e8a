// Casting one ray through an occupancy grid. Every exact caster finds the same cell, and one formula turns
// the cell into a range, so all of them return the identical float.
//
// Units: cells, from the grid's lower-left corner. A ray crosses the vertical grid line b at parameter
// T_x(b) = (b - u) * inv_dx and the horizontal line b at T_y(b) = (b - v) * inv_dy, both rounded to float32
// and both monotone in b. The order of these numbers (ties: y first) *defines* the cells that the ray visits
// (Amanatides & Woo 1987, crossings recomputed from the integer index; SPEC 2.2).
#pragma once

#include <cstdint>

#include "common/map/rays/skip_field.h"
#include "common/math/host_device.h"
#include "common/math/portable.h"

namespace parloc {

/// From a along e, in cells.
struct RayWall {
  float ax, ay, ex, ey;
};

/// Walls that are segments, and which of them pass a cell (common/map/rays/wall_index.h). count 0: walls are
/// cells.
struct Walls {
  const RayWall* wall = nullptr;
  const std::uint32_t* id = nullptr;
  const std::uint32_t* first = nullptr;
  std::uint32_t count = 0;
};

/// What a ray needs of a map. `skip` points at cell (0, 0) of the first plane of a skip field
/// (common/map/rays/skip_field.h): how far to leap; 0 on blocking cells and on the ring around the grid.
struct RayMap {
  const std::uint8_t* skip = nullptr;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t stride = 0;
  float resolution_m = 0.0f;
  float inv_resolution = 0.0f;
  SkipPlanes planes;
  Walls walls;  ///< If there are any, a blocking cell is one where a ray has to look for them.

  PARLOC_HD std::int32_t skip_at(std::int32_t i, std::int32_t j) const {
    return skip[static_cast<std::int64_t>(j) * stride + i];
  }
  /// Lines that a ray of any direction crosses from the cell before it can meet a blocking cell.
  PARLOC_HD std::int32_t free_lines_at(std::int32_t i, std::int32_t j) const {
    return skip[8 * planes.slopes * static_cast<std::int64_t>(planes.bytes) +
                static_cast<std::int64_t>(j) * stride + i];
  }
  PARLOC_HD bool contains_point(float u, float v) const {  // [cells]
    return u >= 0.0f && v >= 0.0f && u < static_cast<float>(width) && v < static_cast<float>(height);
  }
  PARLOC_HD bool contains(std::int32_t i, std::int32_t j) const {
    return i >= 0 && j >= 0 && i < width && j < height;
  }
};

struct Ray {
  float u, v;            // start [cells]
  float dx, dy;          // direction, unit length
  float inv_dx, inv_dy;  // 1 / direction
};

/// A direction component this small never reaches a grid line within any map: no infinities, no 0 * inf.
PARLOC_HD float nonzero_direction(float d) {
  return __builtin_fabsf(d) < 1e-12f ? 1e-20f : d;
}

PARLOC_HD Ray make_ray(float u, float v, float dx, float dy) {
  const float ex = nonzero_direction(dx);
  const float ey = nonzero_direction(dy);
  return {u, v, ex, ey, 1.0f / ex, 1.0f / ey};
}

/// The ray of a beam: (u, v) the sensor's place [cells], c and s of the particle's heading, (bx, by) the
/// beam's direction in the base frame.
PARLOC_HD Ray beam_ray(float u, float v, float c, float s, float bx, float by) {
  return make_ray(u, v, fused_anywhere(c, bx, -(s * by)), fused_anywhere(s, bx, c * by));
}

/// A point given in the base frame, in the grid frame (same unit as x, y).
PARLOC_HD float base_to_grid_x(float x, float c, float s, float px, float py) {
  return fused(c, px, fused(-s, py, x));
}
PARLOC_HD float base_to_grid_y(float y, float c, float s, float px, float py) {
  return fused(s, px, fused(c, py, y));
}

struct RayHit {
  std::int32_t i, j;  // the cell
  bool hit;           // false: nothing within reach
};

/// Parameter at which the ray enters cell (i, j): the later of its two near faces, 0 if it starts inside
/// [cells].
PARLOC_HD float entry_parameter(const Ray& r, std::int32_t i, std::int32_t j) {
  const float tx = (static_cast<float>(i + (r.dx < 0.0f ? 1 : 0)) - r.u) * r.inv_dx;
  const float ty = (static_cast<float>(j + (r.dy < 0.0f ? 1 : 0)) - r.v) * r.inv_dy;
  return max_of(max_of(tx, ty), 0.0f);
}

/// The shared formula: the cell that was hit -> range in metres, at most range_max_m.
PARLOC_HD float range_of_hit(const Ray& r, const RayHit& h, float resolution_m, float range_max_m) {
  const float range_m = entry_parameter(r, h.i, h.j) * resolution_m;
  return h.hit ? min_of(range_m, range_max_m) : range_max_m;
}

/// The index along one axis after all grid lines crossed before t (inclusive: also those at t). `p` is the
/// start and `d`, `inv` the direction of that axis. The floor of p + t d is at most one cell off; the
/// crossings decide.
PARLOC_HD std::int32_t index_at(float p, float d, float inv, float t, bool inclusive) {
  const float c = floor_of(nearly_fused(t, d, p));
  const float below = (c - p) * inv;           // crossing of this cell's lower line
  const float above = ((c + 1.0f) - p) * inv;  // and of its upper line
  const float next = d < 0.0f ? below : above;
  const float last = d < 0.0f ? above : below;
  const bool too_early = inclusive ? next <= t : next < t;
  // A line at or behind the start is not crossed: without this a ray that starts on a line would fall back.
  const bool too_late = last > 0.0f && (inclusive ? last > t : last >= t);
  const float forward = d < 0.0f ? -1.0f : 1.0f;
  const float shift = too_early ? forward : (too_late ? -forward : 0.0f);
  return static_cast<std::int32_t>(c + shift);
}

struct RayStart {
  std::int32_t i, j;
  bool inside;  // false: the ray never meets the grid within reach
};

/// The first cell of the ray inside the grid: its own, or where a ray from outside enters.
PARLOC_HD RayStart start_cell(const RayMap& m, const Ray& r, float reach_cells) {
  const float w = static_cast<float>(m.width);
  const float h = static_cast<float>(m.height);
  const bool in_x = r.u >= 0.0f && r.u < w;
  const bool in_y = r.v >= 0.0f && r.v < h;
  if (in_x && in_y)
    return {static_cast<std::int32_t>(floor_of(r.u)), static_cast<std::int32_t>(floor_of(r.v)), true};
  if (!in_x && (r.dx > 0.0f) != (r.u < 0.0f)) return {0, 0, false};  // outside and moving away
  if (!in_y && (r.dy > 0.0f) != (r.v < 0.0f)) return {0, 0, false};
  const float tx = in_x ? -1.0f : ((r.dx > 0.0f ? 0.0f : w) - r.u) * r.inv_dx;
  const float ty = in_y ? -1.0f : ((r.dy > 0.0f ? 0.0f : h) - r.v) * r.inv_dy;
  const bool by_x = tx >= ty;  // a tie steps y first, so x is the later one
  const float t = by_x ? tx : ty;
  if (!(t < reach_cells)) return {0, 0, false};
  const std::int32_t edge_i = r.dx > 0.0f ? 0 : m.width - 1;
  const std::int32_t edge_j = r.dy > 0.0f ? 0 : m.height - 1;
  const std::int32_t i = by_x ? edge_i : index_at(r.u, r.dx, r.inv_dx, t, false);
  const std::int32_t j = by_x ? index_at(r.v, r.dy, r.inv_dy, t, true) : edge_j;
  return {i, j, m.contains(i, j)};
}

/// Exact traversal, one cell after the other (SPEC 2.2). The reference of all exact casters.
PARLOC_HD RayHit cast_dda(const RayMap& m, const Ray& r, float reach_cells) {
  const RayStart s = start_cell(m, r, reach_cells);
  if (!s.inside) return {0, 0, false};
  std::int32_t i = s.i, j = s.j;
  while (m.contains(i, j)) {
    if (m.skip_at(i, j) == 0) return {i, j, true};
    const float tx = (static_cast<float>(i + (r.dx < 0.0f ? 0 : 1)) - r.u) * r.inv_dx;
    const float ty = (static_cast<float>(j + (r.dy < 0.0f ? 0 : 1)) - r.v) * r.inv_dy;
    const bool step_x = tx < ty;
    if (!((step_x ? tx : ty) < reach_cells)) break;
    i += step_x ? (r.dx < 0.0f ? -1 : 1) : 0;
    j += step_x ? 0 : (r.dy < 0.0f ? -1 : 1);
  }
  return {0, 0, false};
}

/// One axis of a ray for leaping: mirrored where the ray goes down, so that it only ever goes up. Mirroring
/// negates, which is exact: crossings and cells are those of the ray.
struct LeapAxis {
  float u, d;          // as the ray has them
  float up_u, up_inv;  // mirrored start and 1 / direction
  float sign, shift;   // cell c of the ray is cell c * sign + shift of the mirrored axis

  PARLOC_HD static LeapAxis of(float u, float d, float inv) {
    const bool down = d < 0.0f;
    return {u, d, down ? -u : u, __builtin_fabsf(inv), down ? -1.0f : 1.0f, down ? -1.0f : 0.0f};
  }
  PARLOC_HD bool down() const { return d < 0.0f; }
  /// Of a cell of the ray the mirrored one, and back.
  PARLOC_HD std::int32_t mirrored(std::int32_t cell) const { return down() ? -1 - cell : cell; }
  PARLOC_HD float crossing(float line) const { return (line - up_u) * up_inv; }

  /// index_at(), mirrored. `until`: t, or if lines at t are not crossed yet the float in front of it, so that
  /// one comparison does for both.
  PARLOC_HD std::int32_t index_at(float t, float until) const {
    const float c = floor_of(nearly_fused(t, d, u)) * sign + shift;  // exact
    // A line at or behind the start is not crossed: without this a ray that starts on a line would fall back.
    const bool too_late = crossing(c) > max_of(until, 0.0f);
    const bool too_early = crossing(c + 1.0f) <= until;
    return static_cast<std::int32_t>(c) + (too_early ? 1 : (too_late ? -1 : 0));
  }
};

/// The same cells, leaping as many lines of the ray's main axis as the skip field promises. Exact: a leap
/// ends at a grid crossing, and the other axis' index at that crossing is decided by its own crossings
/// (index_at). A leap of one line may cross into the next row first: that is a step of its own, for its cell
/// may block. From `s`, a cell that the ray passes. Ends where it may not go on, which may be off the map, or
/// a little beyond reach.
PARLOC_HD RayHit skip_to_end(const RayMap& m, const Ray& r, const RayStart& s, float reach_cells) {
  if (!s.inside) return {0, 0, false};
  const std::int32_t octant = octant_of(r.dx, r.dy);
  const bool steep = (octant & 4) != 0;
  const float slope = __builtin_fabsf(steep ? r.dx * r.inv_dy : r.dy * r.inv_dx);
  const LeapAxis x = LeapAxis::of(r.u, r.dx, r.inv_dx), y = LeapAxis::of(r.v, r.dy, r.inv_dy);
  const LeapAxis main = steep ? y : x, side = steep ? x : y;
  // Places inside a plane, whose corner is in front of cell (0, 0), fit 32 bits (kMaxMapSide).
  const std::uint8_t* plane =
      m.skip - m.stride - 1 +
      static_cast<std::int64_t>(sector_of(octant, slope, m.planes.slopes)) * m.planes.bytes;
  const std::uint32_t stride = static_cast<std::uint32_t>(m.stride);
  const std::uint32_t step_x = x.down() ? 0u - 1u : 1u, step_y = y.down() ? 0u - stride : stride;
  const std::uint32_t step = steep ? step_y : step_x, side_step = steep ? step_x : step_y;
  const std::uint32_t origin = (x.down() ? 0u : 1u) + (y.down() ? 0u : stride);
  const std::uint32_t in_front = steep ? 1 : 0;  // of t = 0: not a number, which no line is crossed before
  std::int32_t line = steep ? y.mirrored(s.j) : x.mirrored(s.i);
  std::int32_t row = steep ? x.mirrored(s.i) : y.mirrored(s.j);
  for (;;) {
    const std::int32_t lines =
        plane[origin + static_cast<std::uint32_t>(line) * step + static_cast<std::uint32_t>(row) * side_step];
    if (lines == 0) return {x.mirrored(steep ? row : line), y.mirrored(steep ? line : row), true};
    const std::int32_t next = line + lines;
    const float t = main.crossing(static_cast<float>(next));
    const std::int32_t next_row = side.index_at(t, float_of(bits_of(t) - in_front));
    const bool sideways = lines == 1 && next_row != row;
    if (!sideways && !(t < reach_cells)) return {0, 0, false};
    line = sideways ? line : next;
    row = sideways ? row + 1 : next_row;
  }
}

/// From `s` to the blocking cell.
PARLOC_HD RayHit skip_from(const RayMap& m, const Ray& r, const RayStart& s, float reach_cells) {
  const RayHit end = skip_to_end(m, r, s, reach_cells);
  const bool hit = end.hit && m.contains(end.i, end.j) && entry_parameter(r, end.i, end.j) < reach_cells;
  return hit ? end : RayHit{0, 0, false};
}

PARLOC_HD RayHit cast_skip(const RayMap& m, const Ray& r, float reach_cells) {
  return skip_from(m, r, start_cell(m, r, reach_cells), reach_cells);
}

/// range_of_hit(cast_skip()), with one entry parameter for both.
PARLOC_HD float range_by_skip(const RayMap& m, const Ray& r, float reach_cells, float range_max_m) {
  const RayHit end = skip_to_end(m, r, start_cell(m, r, reach_cells), reach_cells);
  const float t = entry_parameter(r, end.i, end.j);
  const bool hit = end.hit && m.contains(end.i, end.j) && t < reach_cells;
  return hit ? min_of(t * m.resolution_m, range_max_m) : range_max_m;
}

/// cast_fixed_step for rays that start outside or take long steps: every point is tested against the grid.
PARLOC_HD float cast_fixed_step_anywhere(const RayMap& m, const Ray& r, float reach_cells, float step_cells,
                                         float range_max_m) {
  const float w = static_cast<float>(m.width), h = static_cast<float>(m.height);
  for (float k = 0.0f;; k += 1.0f) {
    const float t = k * step_cells;
    if (!(t < reach_cells)) return range_max_m;
    const float u = floor_of(fused(t, r.dx, r.u)), v = floor_of(fused(t, r.dy, r.v));
    const bool inside = u >= 0.0f && v >= 0.0f && u < w && v < h;
    if (inside && m.skip_at(static_cast<std::int32_t>(u), static_cast<std::int32_t>(v)) == 0)
      return min_of(t * m.resolution_m, range_max_m);
  }
}

/// The fixed step of Paz et al. 2012 (algorithm 1), points by multiplication; returns metres, at most
/// range_max_m. Approximate: up to a step too long, and chords shorter than a step are missed.
PARLOC_HD float cast_fixed_step(const RayMap& m, const Ray& r, float reach_cells, float step_cells,
                                float range_max_m) {
  if (!m.contains_point(r.u, r.v) || step_cells > 1.0f)
    return cast_fixed_step_anywhere(m, r, reach_cells, step_cells, range_max_m);
  // Steps of at most a cell meet the ring before they are beyond it, so one look-up per step is all.
  // Coordinates from the ring's corner are never negative, so truncation is floor.
  const std::uint8_t* corner = m.skip - m.stride - 1;
  const float u = r.u + 1.0f, v = r.v + 1.0f;
  for (float k = 0.0f;; k += 1.0f) {
    const float t = k * step_cells;
    if (!(t < reach_cells)) return range_max_m;
    const std::int32_t i = static_cast<std::int32_t>(fused(t, r.dx, u));
    const std::int32_t j = static_cast<std::int32_t>(fused(t, r.dy, v));
    if (corner[static_cast<std::int64_t>(j) * m.stride + i] == 0)
      return m.contains(i - 1, j - 1) ? min_of(t * m.resolution_m, range_max_m) : range_max_m;
  }
}

}  // namespace parloc
