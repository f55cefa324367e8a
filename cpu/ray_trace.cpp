// Expected ranges, many beams of one particle at a time. The SIMD lanes do the operations of cast_skip
// (common/map/ray_cast.h) in the same order, so the ranges are the same to the bit; tests hold them together.
#include "common/filter/trace_beam.h"
#include "cpu/stages.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cpu/ray_trace.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cpu/parallel.h"

HWY_BEFORE_NAMESPACE();
namespace parloc::cpu::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Below AVX2 Highway's MulAdd is not fused, and scalable vectors cannot be kept in structs: those run
// cast_skip.
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128 || HWY_HAVE_SCALABLE || \
    (HWY_ARCH_X86 && HWY_TARGET > HWY_AVX2)
void trace_skip(const RayTraceArgs& a, const RayOrigin& o, float* expected_m) {
  for (std::size_t m = 0; m < a.beams.count; ++m) expected_m[m] = trace_beam(a, o, m);
}
#else

using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using MF = hn::Mask<F>;

constexpr F f32;
constexpr I i32;

/// Rays in the lanes of one vector.
struct Rays {
  VF dx, dy, inv_dx, inv_dy;
  VF sign_x, sign_y;  // +1 or -1
  VF far_x, far_y;    // 1 where the direction is negative: the upper line of a cell is the near face
  VF i, j;            // current cell
  MF alive;
};

HWY_INLINE VF nonzero(VF d) {
  return hn::IfThenElse(hn::Lt(hn::Abs(d), hn::Set(f32, 1e-12f)), hn::Set(f32, 1e-20f), d);
}

HWY_INLINE Rays start_rays(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, VF i, VF j) {
  const std::size_t left = a.beams.count > first ? a.beams.count - first : 0;
  const MF used = hn::FirstN(f32, left);
  const VF bx = hn::MaskedLoad(used, f32, a.beams.direction_x + first);
  const VF by = hn::MaskedLoad(used, f32, a.beams.direction_y + first);
  const VF c = hn::Set(f32, o.c), s = hn::Set(f32, o.s), one = hn::Set(f32, 1.0f), zero = hn::Zero(f32);
  Rays r;
  r.dx = nonzero(hn::MulAdd(c, bx, hn::Neg(hn::Mul(s, by))));
  r.dy = nonzero(hn::MulAdd(s, bx, hn::Mul(c, by)));
  r.inv_dx = hn::Div(one, r.dx);
  r.inv_dy = hn::Div(one, r.dy);
  const MF left_x = hn::Lt(r.dx, zero), left_y = hn::Lt(r.dy, zero);
  r.sign_x = hn::IfThenElse(left_x, hn::Set(f32, -1.0f), one);
  r.sign_y = hn::IfThenElse(left_y, hn::Set(f32, -1.0f), one);
  r.far_x = hn::IfThenElseZero(left_x, one);
  r.far_y = hn::IfThenElseZero(left_y, one);
  r.i = i;
  r.j = j;
  r.alive = used;
  return r;
}

/// One jump of cast_skip in every lane that is alive.
HWY_INLINE void advance(const RayMap& map, Rays& r, VF u, VF v, VF reach) {
  const VI at = hn::Add(hn::Mul(hn::ConvertTo(i32, r.j), hn::Set(i32, map.stride)), hn::ConvertTo(i32, r.i));
  const auto* base = reinterpret_cast<const std::int32_t*>(map.skip);
  const VF k = hn::ConvertTo(f32, hn::And(hn::GatherOffset(i32, base, at), hn::Set(i32, 255)));
  const VF line_x = hn::MulAdd(r.sign_x, k, hn::Add(r.i, r.far_x));
  const VF line_y = hn::MulAdd(r.sign_y, k, hn::Add(r.j, r.far_y));
  const VF tx = hn::Mul(hn::Sub(line_x, u), r.inv_dx);
  const VF ty = hn::Mul(hn::Sub(line_y, v), r.inv_dy);
  const MF by_x = hn::Lt(tx, ty);
  const VF t = hn::IfThenElse(by_x, tx, ty);
  // index_at of the other axis.
  const VF p = hn::IfThenElse(by_x, v, u);
  const VF d = hn::IfThenElse(by_x, r.dy, r.dx);
  const VF inv = hn::IfThenElse(by_x, r.inv_dy, r.inv_dx);
  const VF sign = hn::IfThenElse(by_x, r.sign_y, r.sign_x);
  const VF c = hn::Floor(hn::MulAdd(t, d, p));
  const VF below = hn::Mul(hn::Sub(c, p), inv);
  const VF above = hn::Mul(hn::Sub(hn::Add(c, hn::Set(f32, 1.0f)), p), inv);
  const VF next = hn::Max(below, above);  // crossings grow along the ray: the next is the larger
  const VF last = hn::Min(below, above);
  const MF early = hn::Or(hn::Lt(next, t), hn::And(by_x, hn::Eq(next, t)));
  const MF ahead = hn::Gt(last, hn::Zero(f32));
  const MF late = hn::And(ahead, hn::Or(hn::Gt(last, t), hn::AndNot(by_x, hn::Eq(last, t))));
  const VF other =
      hn::Add(c, hn::Sub(hn::IfThenElseZero(early, sign), hn::IfThenElseZero(hn::AndNot(early, late), sign)));

  const MF walks = hn::And(r.alive, hn::Gt(k, hn::Zero(f32)));  // not on a wall or the ring
  const MF within = hn::Lt(t, reach);
  const MF miss = hn::AndNot(within, walks);
  const VF next_i = hn::IfThenElse(by_x, hn::Sub(line_x, r.far_x), other);
  const VF next_j = hn::IfThenElse(by_x, other, hn::Sub(line_y, r.far_y));
  r.alive = hn::And(walks, within);
  r.i = hn::IfThenElse(r.alive, next_i, hn::IfThenElse(miss, hn::Set(f32, -2.0f), r.i));
  r.j = hn::IfThenElse(r.alive, next_j, r.j);
}

HWY_INLINE VF range_of(const RayMap& map, const Rays& r, VF u, VF v, VF range_max) {
  const VF tx = hn::Mul(hn::Sub(hn::Add(r.i, r.far_x), u), r.inv_dx);
  const VF ty = hn::Mul(hn::Sub(hn::Add(r.j, r.far_y), v), r.inv_dy);
  const VF t = hn::Max(hn::Max(tx, ty), hn::Zero(f32));
  const VF range = hn::Min(hn::Mul(t, hn::Set(f32, map.resolution_m)), range_max);
  const VF zero = hn::Zero(f32);
  const MF inside =
      hn::And(hn::And(hn::Ge(r.i, zero), hn::Lt(r.i, hn::Set(f32, static_cast<float>(map.width)))),
              hn::And(hn::Ge(r.j, zero), hn::Lt(r.j, hn::Set(f32, static_cast<float>(map.height)))));
  return hn::IfThenElse(inside, range, range_max);
}

constexpr std::size_t kInFlight = 4;  // vectors whose gathers overlap

void trace_skip(const RayTraceArgs& a, const RayOrigin& o, float* expected_m) {
  const float reach_cells = a.beams.range_max_m * a.map.inv_resolution;
  const bool inside = o.u >= 0.0f && o.v >= 0.0f && o.u < static_cast<float>(a.map.width) &&
                      o.v < static_cast<float>(a.map.height);
  if (!inside) {  // rare: a particle off the map
    for (std::size_t m = 0; m < a.beams.count; ++m) expected_m[m] = trace_beam(a, o, m);
    return;
  }
  const VF u = hn::Set(f32, o.u), v = hn::Set(f32, o.v);
  const VF i = hn::Floor(u), j = hn::Floor(v);
  const VF reach = hn::Set(f32, reach_cells), range_max = hn::Set(f32, a.beams.range_max_m);
  const std::size_t lanes = hn::Lanes(f32);
  for (std::size_t first = 0; first < a.beams.count; first += kInFlight * lanes) {
    Rays r[kInFlight];
    for (std::size_t f = 0; f < kInFlight; ++f) r[f] = start_rays(a, o, first + f * lanes, i, j);
    bool walking = true;
    while (walking) {
      for (std::size_t f = 0; f < kInFlight; ++f) advance(a.map, r[f], u, v, reach);
      MF any = r[0].alive;
      for (std::size_t f = 1; f < kInFlight; ++f) any = hn::Or(any, r[f].alive);
      walking = !hn::AllFalse(f32, any);
    }
    for (std::size_t f = 0; f < kInFlight && first + f * lanes < a.beams.count; ++f) {
      const MF used = hn::FirstN(f32, a.beams.count - first - f * lanes);
      hn::BlendedStore(range_of(a.map, r[f], u, v, range_max), used, f32, expected_m + first + f * lanes);
    }
  }
}
#endif

}  // namespace parloc::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace parloc::cpu {
HWY_EXPORT(trace_skip);

void trace_particle(const RayTraceArgs& args, std::size_t particle, float* expected_m) {
  const RayOrigin origin = ray_origin(args, particle);
  if (args.caster == RayCaster::skip && simd_level() != Simd::baseline) {
    HWY_DYNAMIC_DISPATCH(trace_skip)(args, origin, expected_m);
    return;
  }
  for (std::size_t m = 0; m < args.beams.count; ++m) expected_m[m] = trace_beam(args, origin, m);
}

void ray_trace(const RayTraceArgs& args, Workers& workers) {
  parallel_blocks(args.particles.count, workers.threads, 1,
                  [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
                    for (std::size_t i = begin; i < end; ++i)
                      trace_particle(args, i, args.expected_m + i * args.beams.count);
                  });
}

}  // namespace parloc::cpu
#endif
