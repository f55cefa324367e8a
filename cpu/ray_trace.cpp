// Expected ranges, many beams of one particle at a time; tests hold them against the scalar casters
// (common/filter/trace_beam.h), to the bit.
#include "cpu/ray_trace.h"

#include <algorithm>
#include <limits>

#include "cpu/stages.h"

// Vectors of SVE have no size that the compiler knows, those of a fixed width neither: they cannot be kept in
// structs (cpu/rays-inl.h). CPUs that have it have NEON too. Below AVX2 rays are traced one by one, on any
// set.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_SSSE3 | HWY_SSE4)

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

/// A few leaps for all rays of a particle, then those that go on side by side for a few more, and so on, so
/// that lanes stay busy.
class Tracer {
 public:
  Tracer(const RayTraceArgs& a, float* expected_m, Travellers& rays)
      : a_(a),
        reach_cells_(a.beams.range_max_m * a.map.inv_resolution),
        expected_m_(expected_m),
        on_(rays.on),
        arrived_(rays.arrived),
        walls_(a, expected_m, rays) {}

  void first_leaps(const RayOrigin& o, std::size_t first, std::size_t last, std::size_t row) {
    in_groups(first, last,
              [&](auto group, std::size_t at) { leap_first<decltype(group)::value>(o, at, last, row); });
    if (arrived_.count > 0) walls_.look();
  }
  void rest() {
    while (on_.count > 0) {
      const std::size_t count = on_.count;
      on_.count = 0;  // filled from the front while it is read: what goes on is never more than what was read
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
  HWY_INLINE void leap_first(const RayOrigin& o, std::size_t first, std::size_t last, std::size_t row) {
    const std::size_t lanes = hn::Lanes(f32);
    Rays r[kVectors];
    for (int f = 0; f < kVectors; ++f)
      first_rays(a_, o, first + static_cast<std::size_t>(f) * lanes, last, r[f]);
    leap_all(r);
    for (int f = 0; f < kVectors; ++f) {
      const std::size_t at = row + first + static_cast<std::size_t>(f) * lanes;
      const VI places = hn::Iota(i32, static_cast<std::int32_t>(at));
      hn::StoreU(range_or_look(r[f], places), f32, expected_m_ + at);
      if (!kToTheEnd) keep(r[f], r[f].alive, places, on_);
    }
  }

  template <int kVectors>
  HWY_INLINE void leap_on(std::size_t first, std::size_t count) {
    const std::size_t lanes = hn::Lanes(f32);
    Rays r[kVectors];
    VI places[kVectors];
    for (int f = 0; f < kVectors; ++f) {
      const std::size_t at = first + static_cast<std::size_t>(f) * lanes;
      resumed_rays(a_.map, on_, at, count, r[f]);
      places[f] = places_of(on_, at, count);
    }
    leap_all(r);
    for (int f = 0; f < kVectors; ++f) {
      hn::ScatterIndex(range_or_look(r[f], places[f]), f32, expected_m_, places[f]);
      keep(r[f], r[f].alive, places[f], on_);
    }
  }

  const RayTraceArgs& a_;
  const float reach_cells_;
  float* expected_m_;
  RayQueue &on_, &arrived_;
  WallSearch walls_;
};

void skip_first(const RayTraceArgs& a, const RayOrigin& o, std::size_t first, std::size_t last,
                float* expected_m, std::size_t row, Travellers& on) {
  if (!starts_inside(a, o)) {  // rare: a particle off the map
    for (std::size_t m = first; m < last; ++m) expected_m[row + m] = trace_beam(a, o, m);
    return;
  }
  Tracer(a, expected_m, on).first_leaps(o, first, last, row);
}
void skip_rest(const RayTraceArgs& a, float* expected_m, Travellers& on) {
  Tracer(a, expected_m, on).rest();
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
                float* expected_m, std::size_t row, Travellers&) {
  for (std::size_t m = first; m < last; ++m) expected_m[row + m] = trace_beam(a, o, m);
}
void skip_rest(const RayTraceArgs&, float*, Travellers&) {}
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
                 float* expected_m, std::size_t row, Travellers& on) {
  const bool vectors = simd_level() != Simd::baseline;
  if (args.caster == RayCaster::skip && vectors)
    return HWY_DYNAMIC_DISPATCH(skip_first)(args, origin, first, last, expected_m, row, on);
  if (args.caster == RayCaster::fixed_step && vectors)
    return HWY_DYNAMIC_DISPATCH(march)(args, origin, first, last, expected_m + row);
  run_simd([&]() PARLOC_SIMD_LOOP {
    for (std::size_t m = first; m < last; ++m) expected_m[row + m] = trace_beam(args, origin, m);
  });
}

void trace_rest(const RayTraceArgs& args, float* expected_m, Travellers& on) {
  if (on.on.count > 0) HWY_DYNAMIC_DISPATCH(skip_rest)(args, expected_m, on);
}

void FilterStages::ray_trace(const RayTraceArgs& given, Queue& workers) {
  const RayTraceArgs args = with_input(given);
  const std::size_t beams = args.beams.count, size = row_size(beams), together = particles_together(beams);
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    alignas(64) float rows[kRangeRoom];
    Travellers on;
    for (std::size_t i = begin; i < end; i += together) {
      const std::size_t count = std::min(together, end - i);
      for (std::size_t k = 0; k < count; ++k)
        trace_first(args, ray_origin(args, i + k), 0, beams, rows, k * size, on);
      trace_rest(args, rows, on);
      for (std::size_t k = 0; k < count; ++k)
        std::copy_n(rows + k * size, beams, args.expected_m + (i + k) * beams);
    }
  };
  parallel_blocks(args.particles.count(), workers.threads, 1, loop);
}

}  // namespace parloc::cpu
#endif
