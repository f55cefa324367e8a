// A pose anywhere on the free cells of the map (SPEC 6.2), and the share of the offspring that gets one (SPEC
// 6.3).
#pragma once

#include "common/filter/stages.h"
#include "common/math/philox.h"

namespace parloc {

/// In the grid frame.
struct GridPose {
  float x, y, theta;
};

PARLOC_HD GridPose free_pose(const FreeSpace& free, const Philox4x32& r) {
  const std::uint32_t cell = free.cell[uniform_below(r.w[0], free.count)];
  return {(static_cast<float>(cell % free.width) + uniform_unit(r.w[1])) * free.resolution_m,
          (static_cast<float>(cell / free.width) + uniform_unit(r.w[2])) * free.resolution_m,
          wrap(fused(6.28318548f, uniform_unit(r.w[3]), -3.14159274f))};
}

/// Whether offspring j comes from free space, for a share `inject` of them all.
PARLOC_HD bool is_injected(const FreeSpace& free, double inject, std::uint32_t j, const RandomKey& key) {
  if (!(inject > 0.0) || free.count == 0) return false;
  const Philox4x32 r = philox(j, key.step, Stream::injection, 0, key.seed);
  return static_cast<double>(uniform_unit(r.w[0])) < inject;
}

PARLOC_HD GridPose injected_pose(const FreeSpace& free, std::uint32_t j, const RandomKey& key) {
  return free_pose(free, philox(j, key.step, Stream::uniform_start, 0, key.seed));
}

}  // namespace parloc
