// The rays of one particle on the CPU: the inner loop of ray_trace and of the fused weight.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/filter/trace_beam.h"
#include "common/model/beams.h"

namespace parloc::cpu {

/// Floats that a row of ranges must have room for: those of a scan, and what whole vectors write past them.
constexpr std::size_t kRangeRoom = kMaxBeams + 64;

/// Stands in a row for a range that is not known yet.
constexpr float kUnfinished_m = -1.0f;

/// Rays side by side, each in some cell.
struct RayQueue {
  alignas(64) std::int32_t beam[kRangeRoom];
  alignas(64) float line[kRangeRoom];
  alignas(64) float other_cell[kRangeRoom];
  std::size_t count = 0;
};

/// Pairs of a ray and a wall that are tried at a time.
constexpr std::size_t kPairs = 256;

/// What is known of rays that look at the walls of their cell, by place in the queue, and the pairs to be
/// tried.
struct WallLook {
  std::int32_t cell[kRangeRoom];                   // -1: outside the grid
  float leaves[kRangeRoom];                        // where the ray leaves the cell
  float line[kRangeRoom], other_cell[kRangeRoom];  // where it is then
  float ray[4 * kRangeRoom];                       // u, v, dx, dy
  float nearest[kRangeRoom];
  float pair_ray[4 * kPairs], pair_wall[4 * kPairs], pair_t[kPairs];
  std::uint32_t pair_owner[kPairs];
};

/// Rays that are still on their way after their first leaps, and those of them that have come to a cell with
/// walls to look at.
struct Travellers {
  RayQueue on, arrived;
  WallLook look;
};

/// The first leaps of beams [first, last): writes expected_m[first] to expected_m[last - 1], kUnfinished_m
/// where a ray goes on, and adds those to `on`. Vectors are written whole: up to
/// 63 floats behind `last` too.
void trace_first(const RayTraceArgs& args, const RayOrigin& origin, std::size_t first, std::size_t last,
                 float* expected_m, Travellers& on);
/// Follows `on` to the end: no range is unfinished afterwards.
void trace_rest(const RayTraceArgs& args, const RayOrigin& origin, float* expected_m, Travellers& on);

}  // namespace parloc::cpu
