// The fixed step of Paz et al. 2012, a vector of points of one ray at a time: the operations of
// cast_fixed_step (common/map/rays/ray_cast.h). Compiled once per instruction set by Highway.
#if defined(PARLOC_CPU_RAY_MARCH_INL_H) == defined(HWY_TARGET_TOGGLE)  // once per target
#ifdef PARLOC_CPU_RAY_MARCH_INL_H
#undef PARLOC_CPU_RAY_MARCH_INL_H
#else
#define PARLOC_CPU_RAY_MARCH_INL_H
#endif

#include "cpu/rays-inl.h"

#if PARLOC_RAYS_IN_LANES
HWY_BEFORE_NAMESPACE();
namespace parloc::cpu::HWY_NAMESPACE {

/// One ray of cast_fixed_step from inside the grid, a vector of points at a time.
HWY_INLINE float march_ray(const RayMap& map, const Ray& ray, float reach_cells, float step_cells,
                           float range_max_m) {
  const auto* corner = reinterpret_cast<const std::int32_t*>(map.skip - map.stride - 1);
  const VF dx = hn::Set(f32, ray.dx), dy = hn::Set(f32, ray.dy), zero = hn::Zero(f32);
  const VF u = hn::Set(f32, ray.u + 1.0f), v = hn::Set(f32, ray.v + 1.0f);
  const VF right = hn::Set(f32, static_cast<float>(map.width + 1)),
           top = hn::Set(f32, static_cast<float>(map.height + 1));
  const VF lane = hn::ConvertTo(f32, hn::Iota(i32, 0));
  const VI stride = hn::Set(i32, map.stride), whole = hn::Set(i32, kWholeBits);
  for (float from = 0.0f;; from += static_cast<float>(hn::Lanes(f32))) {
    const VF t = hn::Mul(hn::Add(hn::Set(f32, from), lane), hn::Set(f32, step_cells));
    // Points beyond the grid, behind the one that leaves it, are moved to the ring: they must not be read.
    const VF x = hn::Min(hn::Max(hn::Floor(hn::MulAdd(t, dx, u)), zero), right);
    const VF y = hn::Min(hn::Max(hn::Floor(hn::MulAdd(t, dy, v)), zero), top);
    const VI i = hn::Sub(whole_bits(x), whole), j = hn::Sub(whole_bits(y), whole);
    const VI lines =
        hn::And(hn::GatherOffset(i32, corner, hn::Add(hn::Mul(j, stride), i)), hn::Set(i32, 255));
    const MF within = hn::Lt(t, hn::Set(f32, reach_cells));
    const MF stop = hn::Or(hn::Not(within), hn::RebindMask(f32, hn::Eq(lines, hn::Zero(i32))));
    const std::intptr_t at = hn::FindFirstTrue(f32, stop);
    if (at < 0) continue;
    const float reached = (from + static_cast<float>(at)) * step_cells;
    const std::int32_t ci = static_cast<std::int32_t>(fused(reached, ray.dx, ray.u + 1.0f)) - 1;
    const std::int32_t cj = static_cast<std::int32_t>(fused(reached, ray.dy, ray.v + 1.0f)) - 1;
    const bool hit = reached < reach_cells && map.contains(ci, cj);
    return hit ? min_of(reached * map.resolution_m, range_max_m) : range_max_m;
  }
}

}  // namespace parloc::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
#endif
