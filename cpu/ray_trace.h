// Rays on the CPU, of a few particles at a time: the inner loop of ray_trace and of the fused weight.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/filter/trace_beam.h"
#include "common/model/beams.h"

namespace parloc::cpu {

/// Floats that rows of ranges must have room for: those of a scan, and what whole vectors write past them.
constexpr std::size_t kRangeRoom = kMaxBeams + 64;

/// From the row of one particle to that of the next: whole vectors, whatever is the width of one.
constexpr std::size_t row_size(std::size_t beams) {
  return (beams + 15) / 16 * 16;
}
/// Particles whose rays are followed together: vectors stay full, and many are on their way at a time.
constexpr std::size_t kMostTogether = 16;
constexpr std::size_t particles_together(std::size_t beams) {
  const std::size_t rows = kMaxBeams / row_size(beams > 0 ? beams : 1);
  return rows < kMostTogether ? rows : kMostTogether;
}

/// Stands in a row for a range that is not known yet.
constexpr float kUnfinished_m = -1.0f;

/// Rays side by side, each in some cell.
struct RayQueue {
  alignas(64) std::int32_t place[kRangeRoom];  // of its range, in the rows
  alignas(64) float line[kRangeRoom];
  alignas(64) float other_cell[kRangeRoom];
  alignas(64) float u[kRangeRoom], v[kRangeRoom], dx[kRangeRoom], dy[kRangeRoom];  // as struct Ray
  std::size_t count = 0;
};

/// By a mask of eight lanes: which lanes it has, then the others.
struct FrontLanes {
  std::uint8_t of[256][8];
  constexpr FrontLanes() : of{} {
    for (unsigned mask = 0; mask < 256; ++mask)
      for (unsigned lane = 0, front = 0, back = 7; lane < 8; ++lane)
        of[mask][(mask >> lane & 1) != 0 ? front++ : back--] = static_cast<std::uint8_t>(lane);
  }
};
inline constexpr FrontLanes kFrontLanes;

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

/// The first leaps of beams [first, last) of a particle, whose row begins at `row` of `expected_m`: writes
/// their ranges, kUnfinished_m where a ray goes on, and adds those to `on`. Vectors are written whole: up to
/// 63 floats behind `last` too.
void trace_first(const RayTraceArgs& args, const RayOrigin& origin, std::size_t first, std::size_t last,
                 float* expected_m, std::size_t row, Travellers& on);
/// Follows `on` to the end: no range is unfinished afterwards. Writes expected_m[kMaxBeams] too.
void trace_rest(const RayTraceArgs& args, float* expected_m, Travellers& on);

}  // namespace parloc::cpu
