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

/// Rays in the lanes of one vector. Their main axis is that of the larger direction component; both axes are
/// mirrored where the ray goes down (LeapAxis), so that lines and cells only ever go up.
struct Rays {
  // Written out: a constructor that the compiler implies is for no instruction set in particular, and on ARM
  // cannot call those of vectors.
  HWY_INLINE Rays() {}

  VF u, v, dx, dy;          // as struct Ray
  VF start, other_start;    // [cells], mirrored
  VF inv, other_inv;        // 1 / |direction|
  VF other_d;               // |direction|
  VF other_behind;          // other_start, a little behind: where the floor is taken
  VI stride, other_stride;  // of the table in the ray's sense [bytes]
  VI base;                  // of the sector's plane, and what makes cells of the bits of whole floats
  VI tie;                   // 1 where an equal crossing of the other axis comes later (the main axis is y)
  VI least;                 // 0, or -1 (a NaN) where a line through the start is still to be crossed
  VF line;                  // the current cell on the main axis, mirrored, which is its near line
  VF other_cell;            // the current cell on the other, mirrored
  MF steep;                 // the main axis is y
  MF alive, hit;
};

HWY_INLINE VF nonzero(VF d) {
  return hn::IfThenElse(hn::Lt(hn::Abs(d), hn::Set(f32, 1e-12f)), hn::Set(f32, 1e-20f), d);
}

// The bits of x + 1.5 * 2^23 are those of 1.5 * 2^23 plus x, for whole x of less than 2^22: quicker than a
// conversion that must answer for all floats.
constexpr float kWhole = 12582912.0f;
constexpr std::int32_t kWholeBits = 0x4B400000;

HWY_INLINE VI whole_bits(VF x) {
  return hn::BitCast(i32, hn::Add(x, hn::Set(f32, kWhole)));
}

constexpr float kBehind_cells = 1.0f / 16;  // more than a float32 crossing can err on any map

/// Of cells of rays that go down where `down` the mirrored ones, and back.
HWY_INLINE VF mirrored(VF cell, MF down) {
  return hn::IfThenElse(down, hn::Sub(hn::Set(f32, -1.0f), cell), cell);
}

/// Rays from (u, v) along (dx, dy), in the cells they start in. Written in place: there are too many vectors
/// for registers, and copies of them cost as much as a leap.
HWY_INLINE void start_rays(const RayMap& map, VF u, VF v, VF dx, VF dy, Rays& r) {
  const VF one = hn::Set(f32, 1.0f), zero = hn::Zero(f32);
  const VI one_byte = hn::Set(i32, 1), stride = hn::Set(i32, map.stride);
  r.u = u, r.v = v, r.dx = dx, r.dy = dy;
  const VF abs_x = hn::Abs(dx), abs_y = hn::Abs(dy);
  const MF left = hn::Lt(dx, zero), down = hn::Lt(dy, zero), steep = hn::Gt(abs_y, abs_x);
  const auto steep_i = hn::RebindMask(i32, steep);
  r.steep = steep;
  const VF inv = hn::Div(one, hn::Max(abs_x, abs_y)), other_d = hn::Min(abs_x, abs_y);
  r.inv = inv;
  r.other_inv = hn::Div(one, other_d);
  r.other_d = other_d;
  const VF up_u = hn::IfThenElse(left, hn::Neg(u), u), up_v = hn::IfThenElse(down, hn::Neg(v), v);
  const VF other_start = hn::IfThenElse(steep, up_u, up_v);
  r.start = hn::IfThenElse(steep, up_v, up_u);
  r.other_start = other_start;
  r.other_behind = hn::Sub(other_start, hn::Set(f32, kBehind_cells));
  const VF i = mirrored(hn::Floor(u), left), j = mirrored(hn::Floor(v), down);
  r.line = hn::IfThenElse(steep, j, i);
  r.other_cell = hn::IfThenElse(steep, i, j);

  const auto left_i = hn::RebindMask(i32, left), down_i = hn::RebindMask(i32, down);
  const VI step_x = hn::IfThenElse(left_i, hn::Set(i32, -1), one_byte);
  const VI step_y = hn::IfThenElse(down_i, hn::Neg(stride), stride);
  r.stride = hn::IfThenElse(steep_i, step_y, step_x);
  r.other_stride = hn::IfThenElse(steep_i, step_x, step_y);
  // sector_of; a slope on the edge of two sectors may fall in either: both are right for it
  const std::int32_t slopes = map.planes.slopes;
  const VF cuts = hn::Set(f32, static_cast<float>(slopes));
  const VF part = hn::Min(hn::Floor(hn::Mul(hn::Mul(other_d, inv), cuts)), hn::Sub(cuts, one));
  const VI octant = hn::Add(hn::IfThenElseZero(left_i, hn::Set(i32, slopes)),
                            hn::Add(hn::IfThenElseZero(down_i, hn::Set(i32, 2 * slopes)),
                                    hn::IfThenElseZero(steep_i, hn::Set(i32, 4 * slopes))));
  const VI sector = hn::Add(octant, hn::Sub(whole_bits(part), hn::Set(i32, kWholeBits)));
  // Of cell 0 mirrored, which is cell -1: one step back. whole_bits() in leap() carries kWholeBits once per
  // axis; the product wraps around on purpose.
  const VI origin = hn::Add(hn::IfThenElseZero(left_i, step_x), hn::IfThenElseZero(down_i, step_y));
  const VI offset = hn::Mul(hn::Add(step_x, step_y), hn::Set(i32, kWholeBits));
  r.base = hn::Add(hn::Sub(hn::Mul(sector, hn::Set(i32, map.planes.bytes)), offset), origin);
  r.tie = hn::IfThenElseZero(steep_i, one_byte);
  const auto other_down = hn::RebindMask(i32, hn::Or(hn::And(steep, left), hn::AndNot(steep, down)));
  r.least = hn::IfThenElseZero(other_down, hn::Set(i32, -1));
  r.hit = hn::Lt(one, zero);
}

/// One leap of cast_skip in every lane that is alive.
HWY_INLINE void leap(const RayMap& map, Rays& r, VF reach) {
  const VF one = hn::Set(f32, 1.0f);
  const VI at = hn::Add(hn::Mul(whole_bits(r.line), r.stride),
                        hn::Add(hn::Mul(whole_bits(r.other_cell), r.other_stride), r.base));
  const auto* table = reinterpret_cast<const std::int32_t*>(map.skip);
  const VF lines = hn::ConvertTo(f32, hn::And(hn::GatherOffset(i32, table, at), hn::Set(i32, 255)));
  const VF line = hn::Add(r.line, lines);
  const VF t = hn::Mul(hn::Sub(line, r.start), r.inv);
  // index_at of the other axis. The floor is right or one behind, and the next crossing decides; up to t
  // itself, or up to the float before it where a tie comes later.
  const VF cell = hn::Floor(hn::MulAdd(t, r.other_d, r.other_behind)), next_cell = hn::Add(cell, one);
  const VF next = hn::Mul(hn::Sub(next_cell, r.other_start), r.other_inv);
  const VF until = hn::BitCast(f32, hn::Max(hn::Sub(hn::BitCast(i32, hn::Abs(t)), r.tie), r.least));
  const VF other = hn::IfThenElse(hn::Le(next, until), next_cell, cell);

  const MF walks = hn::And(r.alive, hn::Gt(lines, hn::Zero(f32)));  // not on a wall or the ring
  const MF sideways = hn::And(hn::Eq(lines, one), hn::Ne(other, r.other_cell));
  r.hit = hn::Or(r.hit, hn::AndNot(walks, r.alive));
  r.alive = hn::And(walks, hn::Or(sideways, hn::Lt(t, reach)));
  const VF stepped = hn::IfThenElse(sideways, hn::Add(r.other_cell, one), other);
  r.line = hn::IfThenElse(hn::AndNot(sideways, r.alive), line, r.line);
  r.other_cell = hn::IfThenElse(r.alive, stepped, r.other_cell);
}

/// The cell of the grid that a ray has come to.
struct GridCell {
  VF i, j;
};
HWY_INLINE GridCell grid_cell(const Rays& r) {
  const VF zero = hn::Zero(f32);
  return {mirrored(hn::IfThenElse(r.steep, r.other_cell, r.line), hn::Lt(r.dx, zero)),
          mirrored(hn::IfThenElse(r.steep, r.line, r.other_cell), hn::Lt(r.dy, zero))};
}
HWY_INLINE MF within_grid(const RayMap& map, const GridCell& c) {
  const VF zero = hn::Zero(f32), w = hn::Set(f32, static_cast<float>(map.width)),
           h = hn::Set(f32, static_cast<float>(map.height));
  return hn::And(hn::And(hn::Ge(c.i, zero), hn::Lt(c.i, w)), hn::And(hn::Ge(c.j, zero), hn::Lt(c.j, h)));
}

HWY_INLINE VF range_of(const RayMap& map, const Rays& r, VF reach, VF range_max) {
  const VF along = hn::Mul(hn::Sub(r.line, r.start), r.inv);
  const VF aside = hn::Mul(hn::Sub(r.other_cell, r.other_start), r.other_inv);
  const VF t = hn::Max(hn::Max(along, aside), hn::Zero(f32));
  const VF range = hn::Min(hn::Mul(t, hn::Set(f32, map.resolution_m)), range_max);
  const MF inside = within_grid(map, grid_cell(r));
  return hn::IfThenElse(hn::And(hn::And(r.hit, inside), hn::Lt(t, reach)), range, range_max);
}

/// The lanes of a mask, moved to the front of a vector.
class Packed {
 public:
#if HWY_TARGET == HWY_AVX2  // Highway's Compress copies its table to the stack, for every vector anew
  HWY_INLINE explicit Packed(MF which) : front_(front_of(which)) {}
  HWY_INLINE VF operator()(VF v) const {
    return hn::TableLookupLanes(v, front_);
  }

 private:
  using Front = decltype(hn::IndicesFromVec(f32, hn::Zero(i32)));
  HWY_INLINE static Front front_of(MF which) {
    std::uint8_t bits[8];
    hn::StoreMaskBits(f32, which, bits);
    const hn::Rebind<std::uint8_t, I> bytes;
    return hn::IndicesFromVec(f32, hn::PromoteTo(i32, hn::LoadU(bytes, kFrontLanes.of[bits[0]])));
  }
  Front front_;
#else  // not CompressStore: compressing into memory is microcoded on some CPUs
  HWY_INLINE explicit Packed(MF which) : which_(which) {}
  HWY_INLINE VF operator()(VF v) const {
    return hn::Compress(v, which_);
  }

 private:
  MF which_;
#endif
};

/// Appends the lanes of `which` to the queue.
HWY_INLINE void keep(const Rays& r, MF which, VI places, RayQueue& queue) {
  const Packed packed(which);
  const auto put = [&](VF v, float* to) { hn::StoreU(packed(v), f32, to + queue.count); };
  put(r.line, queue.line), put(r.other_cell, queue.other_cell);
  put(r.u, queue.u), put(r.v, queue.v), put(r.dx, queue.dx), put(r.dy, queue.dy);
  hn::StoreU(hn::BitCast(i32, packed(hn::BitCast(f32, places))), i32, queue.place + queue.count);
  queue.count += hn::CountTrue(f32, which);
}

/// Beams [at, last) of one particle's scan, as many as there are lanes, where they start.
HWY_INLINE void first_rays(const RayTraceArgs& a, const RayOrigin& o, std::size_t at, std::size_t last,
                           Rays& r) {
  const MF used = hn::FirstN(f32, last - at);
  const auto of = [&](const float* p) { return hn::MaskedLoad(used, f32, p + at); };
  const VF cos = hn::Set(f32, o.c), sin = hn::Set(f32, o.s);
  VF u = hn::Set(f32, o.u), v = hn::Set(f32, o.v);
  if (a.beams.origin_spread_m > 0.0f) {  // ray_of_beam
    const VF x = of(a.beams.origin_x), y = of(a.beams.origin_y), per_m = hn::Set(f32, a.map.inv_resolution);
    u = hn::Mul(hn::MulAdd(cos, x, hn::NegMulAdd(sin, y, hn::Set(f32, o.x_m))), per_m);
    v = hn::Mul(hn::MulAdd(sin, x, hn::MulAdd(cos, y, hn::Set(f32, o.y_m))), per_m);
  }
  const VF bx = of(a.beams.direction_x), by = of(a.beams.direction_y);
  const VF dx = nonzero(hn::MulAdd(cos, bx, hn::Neg(hn::Mul(sin, by))));
  const VF dy = nonzero(hn::MulAdd(sin, bx, hn::Mul(cos, by)));
  start_rays(a.map, u, v, dx, dy, r);
  r.alive = used;
}

/// Where the ranges of rays [at, count) of the queue go; those of unused lanes behind all others.
HWY_INLINE VI places_of(const RayQueue& queue, std::size_t at, std::size_t count) {
  const auto used = hn::RebindMask(i32, hn::FirstN(f32, count - at));
  return hn::IfThenElse(used, hn::LoadU(i32, queue.place + at),
                        hn::Set(i32, static_cast<std::int32_t>(kMaxBeams)));
}

/// Rays [at, count) of the queue, as many as there are lanes, where they have come to. Unused lanes are not
/// alive.
HWY_INLINE void resumed_rays(const RayMap& map, const RayQueue& queue, std::size_t at, std::size_t count,
                             Rays& r) {
  const MF used = hn::FirstN(f32, count - at);
  const auto of = [&](const float* p) { return hn::MaskedLoad(used, f32, p + at); };
  const VF one = hn::Set(f32, 1.0f);  // any direction will do for unused lanes
  start_rays(map, of(queue.u), of(queue.v), hn::IfThenElse(used, of(queue.dx), one),
             hn::IfThenElse(used, of(queue.dy), one), r);
  r.line = of(queue.line);
  r.other_cell = of(queue.other_cell);
  r.alive = used;
}

}  // namespace parloc::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
#endif
