// Rays in the lanes of vectors, and the leaps that they make together. The lanes do the operations of
// cast_skip (common/map/rays/ray_cast.h) in the same order, so the bits are the same. Compiled once per
// instruction set by Highway.
#if defined(PARLOC_CPU_RAYS_INL_H) == defined(HWY_TARGET_TOGGLE)  // once per target
#ifdef PARLOC_CPU_RAYS_INL_H
#undef PARLOC_CPU_RAYS_INL_H
#else
#define PARLOC_CPU_RAYS_INL_H
#endif

#include <hwy/highway.h>

#include "cpu/ray_trace.h"

// Below AVX2 Highway's MulAdd is not fused, and scalable vectors cannot be kept in structs: those run
// cast_skip.
#undef PARLOC_RAYS_IN_LANES
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128 || HWY_HAVE_SCALABLE || \
    (HWY_ARCH_X86 && HWY_TARGET > HWY_AVX2)
#define PARLOC_RAYS_IN_LANES 0
#else
#define PARLOC_RAYS_IN_LANES 1
#endif

#if PARLOC_RAYS_IN_LANES
HWY_BEFORE_NAMESPACE();
namespace parloc::cpu::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using MF = hn::Mask<F>;

constexpr F f32;
constexpr I i32;

/// Rays in the lanes of one vector, as their main axis (that of the larger direction component) sees them;
/// the rest is of the other axis.
struct Rays {
  // Written out: a constructor that the compiler implies is for no instruction set in particular, and on ARM
  // cannot call those of vectors.
  HWY_INLINE Rays() {}

  VF start, other_start;    // [cells]
  VF inv, other_inv;        // 1 / direction
  VF sign, other_sign;      // +1 or -1
  VF d, other_d;            // direction
  VF other_behind;          // other_start, a little behind: where the floor is taken
  VF other_ahead;           // 1 or 0: from a cell to the line that the ray crosses next
  VI stride, other_stride;  // of the table [bytes]
  VI base;                  // of the sector's plane, and what makes cells of the bits of whole floats
  VI tie;                   // 1 where an equal crossing of the other axis comes later (the main axis is y)
  VI least;                 // 0, or -1 (a NaN) where a line through the start is still to be crossed
  VF line;                  // the near line of the current cell on the main axis
  VF other_cell;            // the current cell on the other
  MF steep;                 // the main axis is y
  MF alive, hit;
};

HWY_INLINE VF nonzero(VF d) {
  return hn::IfThenElse(hn::Lt(hn::Abs(d), hn::Set(f32, 1e-12f)), hn::Set(f32, 1e-20f), d);
}

/// Where rays start [cells], and the corner of that cell.
struct Start {
  VF u, v, i, j;
};

// The bits of x + 1.5 * 2^23 are those of 1.5 * 2^23 plus x, for whole x of less than 2^22: quicker than a
// conversion that must answer for all floats.
constexpr float kWhole = 12582912.0f;
constexpr std::int32_t kWholeBits = 0x4B400000;

HWY_INLINE VI whole_bits(VF x) {
  return hn::BitCast(i32, hn::Add(x, hn::Set(f32, kWhole)));
}

constexpr float kBehind_cells = 1.0f / 16;  // more than a float32 crossing can err on any map

/// Rays of the given base-frame directions, in the cells they start in.
HWY_INLINE Rays start_rays(const RayMap& map, const RayOrigin& o, const Start& s, VF bx, VF by) {
  const VF cos = hn::Set(f32, o.c), sin = hn::Set(f32, o.s), one = hn::Set(f32, 1.0f), zero = hn::Zero(f32);
  const VF minus = hn::Set(f32, -1.0f);
  const VF dx = nonzero(hn::MulAdd(cos, bx, hn::Neg(hn::Mul(sin, by))));
  const VF dy = nonzero(hn::MulAdd(sin, bx, hn::Mul(cos, by)));
  Rays r;
  r.steep = hn::Gt(hn::Abs(dy), hn::Abs(dx));
  r.d = hn::IfThenElse(r.steep, dy, dx);
  r.other_d = hn::IfThenElse(r.steep, dx, dy);
  r.inv = hn::Div(one, r.d);
  r.other_inv = hn::Div(one, r.other_d);
  // sector_of; a slope on the edge of two sectors may fall in either: both are right for it
  const VF slope = hn::Abs(hn::Mul(r.other_d, r.inv));
  const VF part =
      hn::Min(hn::Floor(hn::Mul(slope, hn::Set(f32, float{kSlopes}))), hn::Set(f32, float{kSlopes - 1}));
  const MF left = hn::Lt(r.d, zero), other_left = hn::Lt(r.other_d, zero);
  const VF octant = hn::Add(hn::IfThenElseZero(hn::Lt(dx, zero), hn::Set(f32, float{kSlopes})),
                            hn::Add(hn::IfThenElseZero(hn::Lt(dy, zero), hn::Set(f32, 2.0f * kSlopes)),
                                    hn::IfThenElseZero(r.steep, hn::Set(f32, 4.0f * kSlopes))));
  const VI sector = hn::Sub(whole_bits(hn::Add(octant, part)), hn::Set(i32, kWholeBits));
  const VI stride = hn::Set(i32, map.stride), one_byte = hn::Set(i32, 1);
  const auto steep_i = hn::RebindMask(i32, r.steep);
  r.stride = hn::IfThenElse(steep_i, stride, one_byte);
  r.other_stride = hn::IfThenElse(steep_i, one_byte, stride);
  r.sign = hn::IfThenElse(left, minus, one);
  r.other_sign = hn::IfThenElse(other_left, minus, one);
  r.other_ahead = hn::IfThenElse(other_left, zero, one);
  r.start = hn::IfThenElse(r.steep, s.v, s.u);
  r.other_start = hn::IfThenElse(r.steep, s.u, s.v);
  r.other_behind = hn::NegMulAdd(r.other_sign, hn::Set(f32, kBehind_cells), r.other_start);
  const VF far = hn::IfThenElseZero(left, one);
  // Wraps around on purpose: whole_bits() in leap() carries kWholeBits once per axis.
  const VI offset = hn::Set(i32, static_cast<std::int32_t>(-static_cast<std::uint32_t>(kWholeBits) *
                                                           static_cast<std::uint32_t>(map.stride + 1)));
  r.base = hn::Sub(hn::Add(hn::Mul(sector, hn::Set(i32, map.skip_plane)), offset),
                   hn::IfThenElseZero(hn::RebindMask(i32, left), r.stride));
  r.tie = hn::IfThenElseZero(steep_i, one_byte);
  r.least = hn::IfThenElseZero(hn::RebindMask(i32, other_left), hn::Set(i32, -1));
  r.line = hn::Add(hn::IfThenElse(r.steep, s.j, s.i), far);
  r.other_cell = hn::IfThenElse(r.steep, s.i, s.j);
  r.hit = hn::Lt(one, zero);
  return r;
}

/// One leap of cast_skip in every lane that is alive.
HWY_INLINE void leap(const RayMap& map, Rays& r, VF reach) {
  const VF one = hn::Set(f32, 1.0f);
  const VI at = hn::Add(hn::Mul(whole_bits(r.line), r.stride),
                        hn::Add(hn::Mul(whole_bits(r.other_cell), r.other_stride), r.base));
  const auto* table = reinterpret_cast<const std::int32_t*>(map.skip);
  const VF lines = hn::ConvertTo(f32, hn::And(hn::GatherOffset(i32, table, at), hn::Set(i32, 255)));
  const VF line = hn::MulAdd(r.sign, lines, r.line);
  const VF t = hn::Mul(hn::Sub(line, r.start), r.inv);
  // index_at of the other axis. The floor is right or one behind, and the next crossing decides; up to t
  // itself, or up to the float before it where a tie comes later.
  const VF cell = hn::Floor(hn::MulAdd(t, r.other_d, r.other_behind));
  const VF next = hn::Mul(hn::Sub(hn::Add(cell, r.other_ahead), r.other_start), r.other_inv);
  const VF until = hn::BitCast(f32, hn::Max(hn::Sub(hn::BitCast(i32, hn::Abs(t)), r.tie), r.least));
  const VF other = hn::IfThenElse(hn::Le(next, until), hn::Add(cell, r.other_sign), cell);

  const MF walks = hn::And(r.alive, hn::Gt(lines, hn::Zero(f32)));  // not on a wall or the ring
  const MF sideways = hn::And(hn::Eq(lines, one), hn::Ne(other, r.other_cell));
  r.hit = hn::Or(r.hit, hn::AndNot(walks, r.alive));
  r.alive = hn::And(walks, hn::Or(sideways, hn::Lt(t, reach)));
  const VF stepped = hn::IfThenElse(sideways, hn::Add(r.other_cell, r.other_sign), other);
  r.line = hn::IfThenElse(hn::AndNot(sideways, r.alive), line, r.line);
  r.other_cell = hn::IfThenElse(r.alive, stepped, r.other_cell);
}

HWY_INLINE VF range_of(const RayMap& map, const Rays& r, VF reach, VF range_max) {
  const VF zero = hn::Zero(f32), one = hn::Set(f32, 1.0f);
  const VF far = hn::IfThenElseZero(hn::Lt(r.sign, zero), one);
  const VF cell = hn::Sub(r.line, far);
  const VF tm = hn::Mul(hn::Sub(r.line, r.start), r.inv);
  const VF to =
      hn::Mul(hn::Sub(hn::Add(r.other_cell, hn::Sub(one, r.other_ahead)), r.other_start), r.other_inv);
  const VF t = hn::Max(hn::Max(tm, to), zero);
  const VF range = hn::Min(hn::Mul(t, hn::Set(f32, map.resolution_m)), range_max);
  const VF w = hn::Set(f32, static_cast<float>(map.width)), h = hn::Set(f32, static_cast<float>(map.height));
  const MF inside =
      hn::And(hn::And(hn::Ge(cell, zero), hn::Lt(cell, hn::IfThenElse(r.steep, h, w))),
              hn::And(hn::Ge(r.other_cell, zero), hn::Lt(r.other_cell, hn::IfThenElse(r.steep, w, h))));
  return hn::IfThenElse(hn::And(hn::And(r.hit, inside), hn::Lt(t, reach)), range, range_max);
}

/// Appends the lanes of `which` to the queue.
HWY_INLINE void keep(const Rays& r, MF which, VI beams, RayQueue& queue) {
  // Not CompressStore: compressing into memory is microcoded on some CPUs.
  hn::StoreU(hn::Compress(r.line, which), f32, queue.line + queue.count);
  hn::StoreU(hn::Compress(r.other_cell, which), f32, queue.other_cell + queue.count);
  hn::StoreU(hn::Compress(beams, hn::RebindMask(i32, which)), i32, queue.beam + queue.count);
  queue.count += hn::CountTrue(f32, which);
}

/// The beams of one particle, ready to be followed from where they start or where they have come to.
struct Fan {
  const RayTraceArgs& a;
  const RayOrigin& o;
  float reach_cells;

  /// Where beams start; `of(p)` gives the lanes' entries of the array p.
  template <class Of>
  HWY_INLINE Start start(const Of& of) const {
    VF u = hn::Set(f32, o.u), v = hn::Set(f32, o.v);
    if (a.beams.origin_spread_m > 0.0f) {  // ray_of_beam
      const VF x = of(a.beams.origin_x), y = of(a.beams.origin_y);
      const VF cos = hn::Set(f32, o.c), sin = hn::Set(f32, o.s), per_m = hn::Set(f32, a.map.inv_resolution);
      u = hn::Mul(hn::MulAdd(cos, x, hn::NegMulAdd(sin, y, hn::Set(f32, o.x_m))), per_m);
      v = hn::Mul(hn::MulAdd(sin, x, hn::MulAdd(cos, y, hn::Set(f32, o.y_m))), per_m);
    }
    return {u, v, hn::Floor(u), hn::Floor(v)};
  }
  template <class Of>
  HWY_INLINE Rays rays(const Of& of, MF used) const {
    Rays r = start_rays(a.map, o, start(of), of(a.beams.direction_x), of(a.beams.direction_y));
    r.alive = used;
    return r;
  }

  /// Beams [at, last) of the scan, as many as there are lanes.
  HWY_INLINE Rays first(std::size_t at, std::size_t last) const {
    const MF used = hn::FirstN(f32, last - at);
    return rays([&](const float* p) { return hn::MaskedLoad(used, f32, p + at); }, used);
  }

  /// Rays [at, count) of the queue, as many as there are lanes. Unused lanes are not alive; they write behind
  /// the last range.
  HWY_INLINE Rays resumed(const RayQueue& queue, std::size_t at, std::size_t count, VI& beams) const {
    const MF used = hn::FirstN(f32, count - at);
    const auto used_i = hn::RebindMask(i32, used);
    const VI beam = hn::IfThenElseZero(used_i, hn::Load(i32, queue.beam + at));
    Rays r = rays([&](const float* p) { return hn::GatherIndex(f32, p, beam); }, used);
    r.line = hn::IfThenElse(used, hn::Load(f32, queue.line + at), r.line);
    r.other_cell = hn::IfThenElse(used, hn::Load(f32, queue.other_cell + at), r.other_cell);
    beams = hn::IfThenElse(used_i, beam, hn::Set(i32, static_cast<std::int32_t>(a.beams.count)));
    return r;
  }
};

}  // namespace parloc::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
#endif
