// What the benchmarks of steps share: the place, the clock, main(), and whether a GPU answers.
#pragma once

#include <benchmark/benchmark.h>

#include <chrono>

#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "common/map/map_reader.h"
#include "common/simulator/simulator.h"

namespace parloc::bench {

/// A map, and a scan from a pose on it.
struct Place {
  GridMap map;
  Scan scan;
  Pose pose;
};

/// The hall with obstacles, half-way along the path of Paz et al. 2012: the first so many of the 541 beams of
/// its LiDAR, simulated against the map of 1 cm.
inline SimulatedLog half_way_through_the_hall(int beams) {
  Scenario scenario = read_scenario(std::string(PARLOC_SOURCE_DIR) + "/configs/paz2012_scenario.yaml");
  scenario.lidar.dropout_probability = 0.0;  // so that every selected beam is used
  scenario.lidar.beams = beams;
  return simulate(scenario, read_map(scenario.map_path), [](double fraction) { return fraction < 0.5; });
}

/// The last scan of that.
inline Place hall_with_scan(int beams) {
  const SimulatedLog log = half_way_through_the_hall(beams);
  Place p;
  p.map = read_map(std::string(PARLOC_SOURCE_DIR) + "/maps/hall_obstacles.yaml");
  p.pose = log.truth.back().pose;
  for (const LogRecord& record : log.records)
    if (record.kind == RecordKind::scan) p.scan = record.scan;
  return p;
}

/// If not, the benchmark's context says why: describe_devices().
inline bool cuda_answers() {
  try {
    FilterBackendConfig config;
    config.particles = 1;
    std::string why;
    make_filter_backend(BackendChoice::cuda, config, why);
    return true;
  } catch (const Error&) {
    return false;
  }
}

inline void count(benchmark::State& state, const char* name, double per_iteration) {
  state.counters[name] = benchmark::Counter(per_iteration, benchmark::Counter::kIsIterationInvariantRate);
}

/// Times `work` by the wall clock; `restore` runs before each iteration, outside of it.
template <class Restore, class Work>
void time_alone(benchmark::State& state, const Restore& restore, const Work& work) {
  using Clock = std::chrono::steady_clock;
  for (auto _ : state) {
    restore();
    const Clock::time_point begun = Clock::now();
    work();
    state.SetIterationTime(std::chrono::duration<double>(Clock::now() - begun).count());
  }
}

/// The main() of a program whose benchmarks `add` registers.
template <class Add>
int run_benchmarks(int argc, char** argv, const Add& add) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  add();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace parloc::bench
