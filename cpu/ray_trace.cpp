// Expected ranges, many beams of one particle at a time; tests hold them against the scalar casters
// (common/filter/trace_beam.h), to the bit.
#include "cpu/ray_trace.h"

#include <algorithm>
#include <limits>

#include "cpu/stages.h"

// Vectors of SVE have no size that the compiler knows, those of a fixed width neither: they cannot be kept in
// structs (cpu/rays-inl.h). CPUs that have it have NEON too.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cpu/ray_trace.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cpu/parallel.h"
#include "cpu/ray_march-inl.h"
#include "cpu/rays-inl.h"
#include "cpu/wall_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace parloc::cpu::HWY_NAMESPACE {

#if PARLOC_RAYS_IN_LANES
// Wide vectors leap a few times, are packed anew, and several at a time let their look-ups overlap. In one of
// four lanes few idle: it leaps until its rays have arrived, which costs less than packing them.
constexpr bool kToTheEnd = hn::MaxLanes(f32) <= 4;
constexpr int kLeapsPerPass = kToTheEnd ? std::numeric_limits<int>::max() : 3;
constexpr int kInFlight = kToTheEnd ? 1 : 4;

/// The rays of one particle: a few leaps for all of them, then those that go on side by side for a few more,
/// and so on, so that lanes stay busy.
class Tracer {
 public:
  Tracer(const RayTraceArgs& a, const RayOrigin& o, float* expected_m, Travellers& rays)
      : fan_{a, o, a.beams.range_max_m * a.map.inv_resolution},
        expected_m_(expected_m),
        on_(rays.on),
        arrived_(rays.arrived),
        walls_(fan_, expected_m, rays) {}

  void first_leaps(std::size_t first, std::size_t last) {
    in_groups(first, last, [&](auto group, std::size_t at) { leap_first<decltype(group)::value>(at, last); });
    if (arrived_.count > 0) walls_.look();
  }
  void rest() {
    while (on_.count > 0) {
      const std::size_t count = on_.count;
      on_.count = 0;
      in_groups(0, count, [&](auto group, std::size_t at) { leap_on<decltype(group)::value>(at, count); });
      if (arrived_.count > 0) walls_.look();
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

  template <int kVectors>
  HWY_INLINE void leap_all(Rays (&r)[kVectors]) {
    const VF reach = hn::Set(f32, fan_.reach_cells);
    for (int k = 0; k < kLeapsPerPass; ++k) {
      MF any = hn::Lt(reach, reach);
      for (int f = 0; f < kVectors; ++f) {
        leap(fan_.a.map, r[f], reach);
        any = hn::Or(any, r[f].alive);
      }
      if (hn::AllFalse(f32, any)) break;
    }
  }
  HWY_INLINE VF range(const Rays& r) const {
    const VF range =
        range_of(fan_.a.map, r, hn::Set(f32, fan_.reach_cells), hn::Set(f32, fan_.a.beams.range_max_m));
    return hn::IfThenElse(r.alive, hn::Set(f32, kUnfinished_m), range);
  }

  /// Where a map's walls are segments, a ray that was stopped has yet to look for them.
  HWY_INLINE VF range_or_look(const Rays& r, VI beams) {
    if (fan_.a.map.walls.count == 0) return range(r);
    keep(r, r.hit, beams, arrived_);
    const VF none = hn::Set(f32, fan_.a.beams.range_max_m);
    return hn::IfThenElse(hn::Or(r.alive, r.hit), hn::Set(f32, kUnfinished_m), none);
  }

  template <int kVectors>
  HWY_INLINE void leap_first(std::size_t first, std::size_t last) {
    const std::size_t lanes = hn::Lanes(f32);
    Rays r[kVectors];
    for (int f = 0; f < kVectors; ++f) r[f] = fan_.first(first + static_cast<std::size_t>(f) * lanes, last);
    leap_all(r);
    for (int f = 0; f < kVectors; ++f) {
      const std::size_t at = first + static_cast<std::size_t>(f) * lanes;
      const VI beams = hn::Iota(i32, static_cast<std::int32_t>(at));
      hn::StoreU(range_or_look(r[f], beams), f32, expected_m_ + at);
      if (!kToTheEnd) keep(r[f], r[f].alive, beams, on_);
    }
  }

  template <int kVectors>
  HWY_INLINE void leap_on(std::size_t first, std::size_t count) {
    const std::size_t lanes = hn::Lanes(f32);
    Rays r[kVectors];
    VI beams[kVectors];
    for (int f = 0; f < kVectors; ++f)
      r[f] = fan_.resumed(on_, first + static_cast<std::size_t>(f) * lanes, count, beams[f]);
    leap_all(r);
    for (int f = 0; f < kVectors; ++f) {
      hn::ScatterIndex(range_or_look(r[f], beams[f]), f32, expected_m_, beams[f]);
      keep(r[f], r[f].alive, beams[f], on_);
    }
  }

  const Fan fan_;
  float* expected_m_;
  RayQueue &on_, &arrived_;
  WallSearch walls_;
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

#else
void skip_first(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, std::size_t last,
                float* expected_m, Travellers&) {
  for (std::size_t m = first; m < last; ++m) expected_m[m] = trace_beam(a, o, m);
}
void skip_rest(const RayTraceArgs&, const RayOrigin&, float*, Travellers&) {}
void march(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, std::size_t last,
           float* expected_m) {
  for (std::size_t m = first; m < last; ++m) expected_m[m] = trace_beam(a, o, m);
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

void FilterStages::ray_trace(const RayTraceArgs& given, Queue& workers) {
  const RayTraceArgs args = with_input(given);
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
