// How long the fields of a large map take. A campus of 10,000 x 7,000 cells (500 x 350 m at 5 cm) is the map
// of the claim "under 2 s on 2 threads, under 16 bytes of memory per cell".
//   ./distance_field_bench [--benchmark_filter=distance_field/walls/threads:2]
// The counter `peak_B_per_cell` is the process' peak memory so far, all of it, over the cells: filter for one
// case to have it for that case.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <random>

#include "common/map/rays/skip_field.h"
#include "tests/unit/measured_field.h"

namespace {

constexpr std::int32_t kWidth = 10000, kHeight = 7000;
constexpr std::size_t kCells = static_cast<std::size_t>(kWidth) * kHeight;
using Mask = std::vector<std::uint8_t>;

/// Straight walls of up to 40 m, as buildings have.
Mask walls() {
  Mask mask(kCells, 0);
  std::mt19937 random(1);
  for (int wall = 0; wall < 4000; ++wall) {
    const std::size_t i = random() % kWidth, j = random() % kHeight, length = random() % 800;
    const bool along_x = random() % 2 != 0;
    for (std::size_t t = 0; t < length; ++t) {
      const std::size_t a = along_x ? i + t : i, b = along_x ? j : j + t;
      if (a < kWidth && b < kHeight) mask[b * kWidth + a] = 1;
    }
  }
  return mask;
}

/// Every hundredth cell at random: the most parabolas that meet, the hardest case for the branch predictor.
Mask speckle() {
  Mask mask(kCells);
  std::mt19937 random(2);
  for (auto& cell : mask) cell = random() % 100 == 0 ? std::uint8_t{1} : std::uint8_t{0};
  return mask;
}

/// One occupied cell: the longest distances.
Mask lone() {
  Mask mask(kCells, 0);
  mask[kCells / 2] = 1;
  return mask;
}

void report_memory(benchmark::State& state) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["peak_B_per_cell"] =
      static_cast<double>(usage.ru_maxrss) * 1024.0 / static_cast<double>(kCells);
  state.counters["cells/s"] =
      benchmark::Counter(static_cast<double>(kCells), benchmark::Counter::kIsIterationInvariantRate);
}

void distance_field(benchmark::State& state, Mask (*map)()) {
  const Mask mask = map();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        parloc::test::squared_distance_field(mask.data(), kWidth, kHeight, static_cast<int>(state.range(0))));
  }
  report_memory(state);
}

void skip_field(benchmark::State& state, Mask (*map)()) {
  const Mask mask = map();
  for (auto _ : state) benchmark::DoNotOptimize(parloc::skip_field(mask.data(), kWidth, kHeight, 0));
  report_memory(state);
}

#define PARLOC_FIELD_BENCH(map)               \
  BENCHMARK_CAPTURE(distance_field, map, map) \
      ->ArgName("threads")                    \
      ->Arg(1)                                \
      ->Arg(2)                                \
      ->UseRealTime()                         \
      ->Unit(benchmark::kMillisecond)
PARLOC_FIELD_BENCH(walls);
PARLOC_FIELD_BENCH(speckle);
PARLOC_FIELD_BENCH(lone);
BENCHMARK_CAPTURE(skip_field, walls, walls)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(skip_field, speckle, speckle)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
