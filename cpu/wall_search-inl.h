// The nearest wall of the cell that a ray has come to, for maps whose walls are segments. Compiled once
// per instruction set by Highway.
#if defined(PARLOC_CPU_WALL_SEARCH_INL_H) == defined(HWY_TARGET_TOGGLE)  // once per target
#ifdef PARLOC_CPU_WALL_SEARCH_INL_H
#undef PARLOC_CPU_WALL_SEARCH_INL_H
#else
#define PARLOC_CPU_WALL_SEARCH_INL_H
#endif

#include <cstring>

#include "cpu/rays-inl.h"

#if PARLOC_RAYS_IN_LANES
HWY_BEFORE_NAMESPACE();
namespace parloc::cpu::HWY_NAMESPACE {

/// wall_hit in every lane.
HWY_INLINE VF hit_walls(const float* rays, const float* walls) {
  VF u, v, dx, dy, ax, ay, ex, ey;
  hn::LoadInterleaved4(f32, rays, u, v, dx, dy);
  hn::LoadInterleaved4(f32, walls, ax, ay, ex, ey);
  const VF zero = hn::Zero(f32), one = hn::Set(f32, 1.0f), small = hn::Set(f32, kWallSlack);
  const auto cross = [](VF px, VF py, VF qx, VF qy) { return hn::MulAdd(px, qy, hn::Neg(hn::Mul(py, qx))); };
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

class WallSearch {
 public:
  WallSearch(const RayTraceArgs& a, float* expected_m, Travellers& rays)
      : map_(a.map),
        range_max_m_(a.beams.range_max_m),
        expected_m_(expected_m),
        on_(rays.on),
        arrived_(rays.arrived),
        look_(rays.look) {}

  /// The part of cast_walls between leaps, look_in_cell for all rays that have come to a cell with walls:
  /// finds the nearest of them. A ray that leaves the cell before it goes on from the next one.
  void look() {
    const std::size_t lanes = hn::Lanes(f32), count = arrived_.count;
    for (std::size_t at = 0; at < count; at += lanes) prepare(at, count);
    find_nearest(count);
    for (std::size_t at = 0; at < count; at += lanes) settle(at, count);
    arrived_.count = 0;
  }

 private:
  /// Where rays are, when they leave their cell, and where they are then.
  HWY_INLINE void prepare(std::size_t at, std::size_t count) {
    Rays r;
    resumed_rays(map_, arrived_, at, count, r);
    const VF one = hn::Set(f32, 1.0f);
    const VF line = hn::Add(r.line, one), other_cell = hn::Add(r.other_cell, one);
    const VF next = hn::Mul(hn::Sub(line, r.start), r.inv);
    const VF other_next = hn::Mul(hn::Sub(other_cell, r.other_start), r.other_inv);
    // As cast_dda: a tie goes along y first.
    const MF onward = hn::Or(hn::Lt(next, other_next), hn::And(r.steep, hn::Eq(next, other_next)));
    const GridCell c = grid_cell(r);
    const VI index =
        hn::Add(hn::Mul(hn::ConvertTo(i32, c.j), hn::Set(i32, map_.width)), hn::ConvertTo(i32, c.i));
    const auto looks = hn::RebindMask(i32, hn::And(r.alive, within_grid(map_, c)));
    hn::StoreU(hn::IfThenElse(looks, index, hn::Set(i32, -1)), i32, look_.cell + at);
    hn::StoreU(hn::IfThenElse(onward, next, other_next), f32, look_.leaves + at);
    hn::StoreU(hn::IfThenElse(onward, line, r.line), f32, look_.line + at);
    hn::StoreU(hn::IfThenElse(onward, r.other_cell, other_cell), f32, look_.other_cell + at);
    hn::StoreInterleaved4(r.u, r.v, r.dx, r.dy, f32, look_.ray + 4 * at);
  }

  /// The nearest wall in each ray's cell. Rays and walls are put side by side in pairs, so that no lane waits
  /// for a fuller cell.
  void find_nearest(std::size_t count) {
    const Walls& walls = map_.walls;
    std::size_t pairs = 0;
    for (std::size_t k = 0; k < count; ++k) {
      look_.nearest[k] = kNoWall;
      const std::int32_t cell = look_.cell[k];
      if (cell < 0) continue;
      for (std::uint32_t w = walls.first[cell]; w < walls.first[cell + 1]; ++w) {
        std::memcpy(look_.pair_ray + 4 * pairs, look_.ray + 4 * k, 4 * sizeof(float));
        std::memcpy(look_.pair_wall + 4 * pairs, walls.wall + walls.id[w], sizeof(RayWall));
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

  HWY_INLINE void settle(std::size_t at, std::size_t count) {
    const MF used = hn::FirstN(f32, count - at);
    const VI places = places_of(arrived_, at, count);
    const VF nearest = hn::LoadU(f32, look_.nearest + at), leaves = hn::LoadU(f32, look_.leaves + at);
    const VF reach = hn::Set(f32, range_max_m_ * map_.inv_resolution), none = hn::Set(f32, range_max_m_);
    const MF looked = hn::RebindMask(f32, hn::Gt(hn::LoadU(i32, look_.cell + at), hn::Set(i32, -1)));
    const MF found = hn::And(looked, hn::Le(nearest, leaves));
    const MF on = hn::And(hn::AndNot(found, looked), hn::And(used, hn::Lt(leaves, reach)));
    const VF range = hn::Min(hn::Mul(nearest, hn::Set(f32, map_.resolution_m)), none);
    const VF known = hn::IfThenElse(hn::And(found, hn::Lt(nearest, reach)), range, none);
    hn::ScatterIndex(hn::IfThenElse(on, hn::Set(f32, kUnfinished_m), known), f32, expected_m_, places);
    Rays next;
    resumed_rays(map_, arrived_, at, count, next);
    next.line = hn::LoadU(f32, look_.line + at);
    next.other_cell = hn::LoadU(f32, look_.other_cell + at);
    keep(next, on, places, on_);
  }

  const RayMap& map_;
  const float range_max_m_;
  float* expected_m_;
  RayQueue &on_, &arrived_;
  WallLook& look_;
};

}  // namespace parloc::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
#endif
