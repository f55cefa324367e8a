// Expected ranges, many beams of one particle at a time. The SIMD lanes do the operations of cast_skip
// (common/map/ray_cast.h) in the same order, so the ranges are the same to the bit; tests hold them together.
#include "cpu/ray_trace.h"

#include <algorithm>
#include <cstring>

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
void skip_first(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, std::size_t last,
                float* expected_m, Travellers&) {
  for (std::size_t m = first; m < last; ++m) expected_m[m] = trace_beam(a, o, m);
}
void skip_rest(const RayTraceArgs&, const RayOrigin&, float*, Travellers&) {}
void march(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, std::size_t last,
           float* expected_m) {
  for (std::size_t m = first; m < last; ++m) expected_m[m] = trace_beam(a, o, m);
}
#else

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

constexpr int kLeapsPerPass = 3;
constexpr int kInFlight = 4;  // vectors whose look-ups overlap

HWY_INLINE void keep(const Rays& r, MF which, VI beams, Queue& queue) {
  // Not CompressStore: compressing into memory is microcoded on some CPUs.
  hn::StoreU(hn::Compress(r.line, which), f32, queue.line + queue.count);
  hn::StoreU(hn::Compress(r.other_cell, which), f32, queue.other_cell + queue.count);
  hn::StoreU(hn::Compress(beams, hn::RebindMask(i32, which)), i32, queue.beam + queue.count);
  queue.count += hn::CountTrue(f32, which);
}

/// The rays of one particle: a few leaps for all of them, then those that go on side by side for a few more,
/// and so on, so that lanes stay busy.
class Tracer {
 public:
  Tracer(const RayTraceArgs& a, const RayOrigin& o, float* expected_m, Travellers& on)
      : a_(a),
        o_(o),
        expected_m_(expected_m),
        on_(on.on),
        arrived_(on.arrived),
        look_(on.look),
        reach_cells_(a.beams.range_max_m * a.map.inv_resolution) {}

  void first_leaps(std::size_t first, std::size_t last) {
    in_groups(first, last, [&](auto group, std::size_t at) { leap_first<decltype(group)::value>(at, last); });
    if (arrived_.count > 0) look_at_walls();
  }
  void rest() {
    while (on_.count > 0) {
      const std::size_t count = on_.count;
      on_.count = 0;
      in_groups(0, count, [&](auto group, std::size_t at) { leap_on<decltype(group)::value>(at, count); });
      if (arrived_.count > 0) look_at_walls();
    }
  }

 private:
  template <int kVectors>
  struct Group {
    static constexpr int value = kVectors;
  };

  /// leap(Group<n>, at) for groups of kInFlight vectors, then for what is left.
  template <class Leap>
  HWY_INLINE void in_groups(std::size_t at, std::size_t last, const Leap& leap) {
    const std::size_t lanes = hn::Lanes(f32);
    for (; at + (kInFlight - 1) * lanes < last; at += kInFlight * lanes) leap(Group<kInFlight>(), at);
    if (at + 2 * lanes < last) return leap(Group<3>(), at);
    if (at + lanes < last) return leap(Group<2>(), at);
    if (at < last) leap(Group<1>(), at);
  }

  /// `origin(p)` gives the lanes' entries of the array p: origin_x or origin_y.
  template <class Origin>
  HWY_INLINE Start start(const Origin& origin) const {
    VF u = hn::Set(f32, o_.u), v = hn::Set(f32, o_.v);
    if (a_.beams.origin_spread_m > 0.0f) {  // ray_of_beam
      const VF x = origin(a_.beams.origin_x), y = origin(a_.beams.origin_y);
      const VF cos = hn::Set(f32, o_.c), sin = hn::Set(f32, o_.s),
               per_m = hn::Set(f32, a_.map.inv_resolution);
      u = hn::Mul(hn::MulAdd(cos, x, hn::NegMulAdd(sin, y, hn::Set(f32, o_.x_m))), per_m);
      v = hn::Mul(hn::MulAdd(sin, x, hn::MulAdd(cos, y, hn::Set(f32, o_.y_m))), per_m);
    }
    return {u, v, hn::Floor(u), hn::Floor(v)};
  }
  template <int kVectors>
  HWY_INLINE void leap_all(Rays (&r)[kVectors]) {
    const VF reach = hn::Set(f32, reach_cells_);
    for (int k = 0; k < kLeapsPerPass; ++k) {
      MF any = hn::Lt(reach, reach);
      for (int f = 0; f < kVectors; ++f) {
        leap(a_.map, r[f], reach);
        any = hn::Or(any, r[f].alive);
      }
      if (hn::AllFalse(f32, any)) break;
    }
  }
  HWY_INLINE VF range(const Rays& r) const {
    const VF range = range_of(a_.map, r, hn::Set(f32, reach_cells_), hn::Set(f32, a_.beams.range_max_m));
    return hn::IfThenElse(r.alive, hn::Set(f32, kUnfinished_m), range);
  }

  /// Where a map's walls are segments, a ray that was stopped has yet to look for them.
  HWY_INLINE VF range_or_look(const Rays& r, VI beams) {
    if (a_.map.walls.count == 0) return range(r);
    keep(r, r.hit, beams, arrived_);
    const VF none = hn::Set(f32, a_.beams.range_max_m);
    return hn::IfThenElse(hn::Or(r.alive, r.hit), hn::Set(f32, kUnfinished_m), none);
  }

  template <int kVectors>
  HWY_INLINE void leap_first(std::size_t first, std::size_t last) {
    const std::size_t lanes = hn::Lanes(f32);
    Rays r[kVectors];
    for (int f = 0; f < kVectors; ++f) {
      const std::size_t at = first + static_cast<std::size_t>(f) * lanes;
      const MF used = hn::FirstN(f32, last - at);
      const auto of = [&](const float* p) { return hn::MaskedLoad(used, f32, p + at); };
      r[f] = start_rays(a_.map, o_, start(of), of(a_.beams.direction_x), of(a_.beams.direction_y));
      r[f].alive = used;
    }
    leap_all(r);
    for (int f = 0; f < kVectors; ++f) {
      const std::size_t at = first + static_cast<std::size_t>(f) * lanes;
      const VI beams = hn::Iota(i32, static_cast<std::int32_t>(at));
      hn::StoreU(range_or_look(r[f], beams), f32, expected_m_ + at);
      keep(r[f], r[f].alive, beams, on_);
    }
  }

  template <int kVectors>
  HWY_INLINE void leap_on(std::size_t first, std::size_t count) {
    const std::size_t lanes = hn::Lanes(f32);
    Rays r[kVectors];
    VI beams[kVectors];
    for (int f = 0; f < kVectors; ++f)
      r[f] = resumed(on_, first + static_cast<std::size_t>(f) * lanes, count, beams[f]);
    leap_all(r);
    for (int f = 0; f < kVectors; ++f) {
      hn::ScatterIndex(range_or_look(r[f], beams[f]), f32, expected_m_, beams[f]);
      keep(r[f], r[f].alive, beams[f], on_);
    }
  }

  /// Rays [at, count) of the queue, as many as there are lanes. Unused lanes are not alive; they write behind
  /// the last range.
  HWY_INLINE Rays resumed(const Queue& queue, std::size_t at, std::size_t count, VI& beams) const {
    const MF used = hn::FirstN(f32, count - at);
    const auto used_i = hn::RebindMask(i32, used);
    const VI beam = hn::IfThenElseZero(used_i, hn::Load(i32, queue.beam + at));
    const auto of = [&](const float* p) { return hn::GatherIndex(f32, p, beam); };
    Rays r = start_rays(a_.map, o_, start(of), of(a_.beams.direction_x), of(a_.beams.direction_y));
    r.alive = used;
    r.line = hn::IfThenElse(used, hn::Load(f32, queue.line + at), r.line);
    r.other_cell = hn::IfThenElse(used, hn::Load(f32, queue.other_cell + at), r.other_cell);
    beams = hn::IfThenElse(used_i, beam, hn::Set(i32, static_cast<std::int32_t>(a_.beams.count)));
    return r;
  }

  /// The part of cast_walls between leaps, look_in_cell for all rays that have come to a cell with walls:
  /// finds the nearest of them. A ray that leaves the cell before it goes on from the next one.
  void look_at_walls() {
    const std::size_t lanes = hn::Lanes(f32), count = arrived_.count;
    for (std::size_t at = 0; at < count; at += lanes) prepare(at, count);
    find_nearest(count);
    for (std::size_t at = 0; at < count; at += lanes) settle(at, count);
    arrived_.count = 0;
  }

  /// Where rays are, when they leave their cell, and where they are then.
  HWY_INLINE void prepare(std::size_t at, std::size_t count) {
    VI beams;
    const Rays r = resumed(arrived_, at, count, beams);
    const VF far = hn::IfThenElseZero(hn::Lt(r.sign, hn::Zero(f32)), hn::Set(f32, 1.0f));
    const VF cell = hn::Sub(r.line, far);
    const VF i = hn::IfThenElse(r.steep, r.other_cell, cell), j = hn::IfThenElse(r.steep, cell, r.other_cell);
    const VF next = hn::Mul(hn::Sub(hn::Add(r.line, r.sign), r.start), r.inv);
    const VF other_next = hn::Mul(hn::Sub(hn::Add(r.other_cell, r.other_ahead), r.other_start), r.other_inv);
    // As cast_dda: a tie goes along y first.
    const MF onward = hn::Or(hn::Lt(next, other_next), hn::And(r.steep, hn::Eq(next, other_next)));
    const VI index =
        hn::Add(hn::Mul(hn::ConvertTo(i32, j), hn::Set(i32, a_.map.width)), hn::ConvertTo(i32, i));
    const auto looks = hn::RebindMask(i32, hn::And(r.alive, within_grid(i, j)));
    hn::StoreU(hn::IfThenElse(looks, index, hn::Set(i32, -1)), i32, look_.cell + at);
    hn::StoreU(hn::IfThenElse(onward, next, other_next), f32, look_.leaves + at);
    hn::StoreU(hn::IfThenElse(onward, hn::Add(r.line, r.sign), r.line), f32, look_.line + at);
    hn::StoreU(hn::IfThenElse(onward, r.other_cell, hn::Add(r.other_cell, r.other_sign)), f32,
               look_.other_cell + at);
    hn::StoreInterleaved4(hn::IfThenElse(r.steep, r.other_start, r.start),
                          hn::IfThenElse(r.steep, r.start, r.other_start),
                          hn::IfThenElse(r.steep, r.other_d, r.d), hn::IfThenElse(r.steep, r.d, r.other_d),
                          f32, look_.ray + 4 * at);
  }

  /// The nearest wall in each ray's cell. Rays and walls are put side by side in pairs, so that no lane waits
  /// for a fuller cell.
  void find_nearest(std::size_t count) {
    const Walls& walls = a_.map.walls;
    std::size_t pairs = 0;
    for (std::size_t k = 0; k < count; ++k) {
      look_.nearest[k] = kNoWall;
      const std::int32_t cell = look_.cell[k];
      if (cell < 0) continue;
      for (std::uint32_t w = walls.first[cell]; w < walls.first[cell + 1]; ++w) {
        std::memcpy(look_.pair_ray + 4 * pairs, look_.ray + 4 * k, 4 * sizeof(float));
        std::memcpy(look_.pair_wall + 4 * pairs, walls.wall + walls.id[w], sizeof(Wall));
        look_.pair_owner[pairs] = static_cast<std::uint32_t>(k);
        if (++pairs == kPairs) hit_pairs(pairs), pairs = 0;
      }
    }
    hit_pairs(pairs);
  }

  HWY_INLINE void hit_pairs(std::size_t pairs) {
    for (std::size_t p = 0; p < pairs; p += hn::Lanes(f32))
      hn::StoreU(hit_walls(look_.pair_ray + 4 * p, look_.pair_wall + 4 * p), f32, look_.pair_t + p);
    for (std::size_t p = 0; p < pairs; ++p) {
      float& nearest = look_.nearest[look_.pair_owner[p]];
      nearest = look_.pair_t[p] < nearest ? look_.pair_t[p] : nearest;
    }
  }

  /// wall_hit in every lane.
  HWY_INLINE VF hit_walls(const float* rays, const float* walls) const {
    VF u, v, dx, dy, ax, ay, ex, ey;
    hn::LoadInterleaved4(f32, rays, u, v, dx, dy);
    hn::LoadInterleaved4(f32, walls, ax, ay, ex, ey);
    const VF zero = hn::Zero(f32), one = hn::Set(f32, 1.0f), small = hn::Set(f32, kWallSlack);
    const auto cross = [](VF px, VF py, VF qx, VF qy) {
      return hn::MulAdd(px, qy, hn::Neg(hn::Mul(py, qx)));
    };
    const auto dot = [](VF px, VF py, VF qx, VF qy) { return hn::MulAdd(px, qx, hn::Mul(py, qy)); };
    const VF x = hn::Sub(ax, u), y = hn::Sub(ay, v);
    const VF slack = hn::Mul(small, hn::Max(hn::Max(hn::Abs(x), hn::Abs(y)), one));
    const VF det = cross(dx, dy, ex, ey), off = cross(x, y, dx, dy);
    const VF start = dot(x, y, dx, dy), extent = dot(ex, ey, dx, dy);
    const VF size = hn::Abs(det);
    const VF across = hn::IfThenElse(hn::Lt(det, zero), hn::Neg(off), off);
    const MF passes = hn::And(hn::Ge(across, hn::Neg(slack)), hn::Le(across, hn::Add(size, slack)));
    const VF share = hn::Min(hn::Max(hn::Div(off, det), zero), one);
    const VF crossing = hn::MulAdd(share, extent, start);
    const VF end = hn::Add(start, extent), low = hn::Min(start, end);
    const MF within = hn::And(hn::Le(low, zero), hn::Ge(hn::Max(start, end), zero));
    const VF along = hn::IfThenElse(within, zero, low);
    const MF parallel = hn::Le(size, hn::Mul(small, hn::Add(hn::Abs(ex), hn::Abs(ey))));
    const VF t = hn::IfThenElse(parallel, along, crossing);
    return hn::IfThenElse(hn::And(passes, hn::Ge(t, zero)), t, hn::Set(f32, kNoWall));
  }

  HWY_INLINE void settle(std::size_t at, std::size_t count) {
    const MF used = hn::FirstN(f32, count - at);
    const auto used_i = hn::RebindMask(i32, used);
    const VI beams = hn::IfThenElse(used_i, hn::Load(i32, arrived_.beam + at),
                                    hn::Set(i32, static_cast<std::int32_t>(a_.beams.count)));
    const VF nearest = hn::LoadU(f32, look_.nearest + at), leaves = hn::LoadU(f32, look_.leaves + at);
    const VF reach = hn::Set(f32, reach_cells_), none = hn::Set(f32, a_.beams.range_max_m);
    const MF looked = hn::RebindMask(f32, hn::Gt(hn::LoadU(i32, look_.cell + at), hn::Set(i32, -1)));
    const MF found = hn::And(looked, hn::Le(nearest, leaves));
    const MF on = hn::And(hn::AndNot(found, looked), hn::And(used, hn::Lt(leaves, reach)));
    const VF range = hn::Min(hn::Mul(nearest, hn::Set(f32, a_.map.resolution_m)), none);
    const VF known = hn::IfThenElse(hn::And(found, hn::Lt(nearest, reach)), range, none);
    hn::ScatterIndex(hn::IfThenElse(on, hn::Set(f32, kUnfinished_m), known), f32, expected_m_, beams);
    Rays next;
    next.line = hn::LoadU(f32, look_.line + at);
    next.other_cell = hn::LoadU(f32, look_.other_cell + at);
    keep(next, on, beams, on_);
  }

  HWY_INLINE MF within_grid(VF i, VF j) const {
    const VF zero = hn::Zero(f32), w = hn::Set(f32, static_cast<float>(a_.map.width)),
             h = hn::Set(f32, static_cast<float>(a_.map.height));
    return hn::And(hn::And(hn::Ge(i, zero), hn::Lt(i, w)), hn::And(hn::Ge(j, zero), hn::Lt(j, h)));
  }

  const RayTraceArgs& a_;
  const RayOrigin& o_;
  float* expected_m_;
  Queue &on_, &arrived_;
  WallLook& look_;
  float reach_cells_;
};

void skip_first(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, std::size_t last,
                float* expected_m, Travellers& on) {
  if (!starts_inside(a, o)) {  // rare: a particle off the map
    for (std::size_t m = first; m < last; ++m) expected_m[m] = trace_beam(a, o, m);
    return;
  }
  Tracer(a, o, expected_m, on).first_leaps(first, last);
}
void skip_rest(const RayTraceArgs& a, const RayOrigin& o, float* expected_m, Travellers& on) {
  Tracer(a, o, expected_m, on).rest();
}
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

void march(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, std::size_t last,
           float* expected_m) {
  const bool inside = starts_inside(a, o);
  const float range_max_m = a.beams.range_max_m, reach_cells = range_max_m * a.map.inv_resolution;
  for (std::size_t m = first; m < last; ++m) {
    const Ray ray = ray_of_beam(a, o, m);
    expected_m[m] = inside && a.fixed_step_cells <= 1.0f
                        ? march_ray(a.map, ray, reach_cells, a.fixed_step_cells, range_max_m)
                        : trace_beam(a, o, m);
  }
}
#endif

}  // namespace parloc::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace parloc::cpu {
HWY_EXPORT(skip_first);
HWY_EXPORT(skip_rest);
HWY_EXPORT(march);

void trace_first(const RayTraceArgs& args, const RayOrigin& origin, std::size_t first, std::size_t last,
                 float* expected_m, Travellers& on) {
  const bool vectors = simd_level() != Simd::baseline;
  if (args.caster == RayCaster::skip && vectors)
    return HWY_DYNAMIC_DISPATCH(skip_first)(args, origin, first, last, expected_m, on);
  if (args.caster == RayCaster::fixed_step && vectors)
    return HWY_DYNAMIC_DISPATCH(march)(args, origin, first, last, expected_m);
  run_simd([&]() PARLOC_SIMD_LOOP {
    for (std::size_t m = first; m < last; ++m) expected_m[m] = trace_beam(args, origin, m);
  });
}

void trace_rest(const RayTraceArgs& args, const RayOrigin& origin, float* expected_m, Travellers& on) {
  if (on.on.count > 0) HWY_DYNAMIC_DISPATCH(skip_rest)(args, origin, expected_m, on);
}

void ray_trace(const RayTraceArgs& args, Workers& workers) {
  const std::size_t beams = args.beams.count;
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    alignas(64) float row[kRangeRoom];
    Travellers on;
    for (std::size_t i = begin; i < end; ++i) {
      const RayOrigin origin = ray_origin(args, i);
      on.on.count = 0;
      trace_first(args, origin, 0, beams, row, on);
      trace_rest(args, origin, row, on);
      std::copy(row, row + beams, args.expected_m + i * beams);
    }
  };
  parallel_blocks(args.particles.count(), workers.threads, 1, loop);
}

}  // namespace parloc::cpu
#endif
