// How long a step of the flow and Kalman filters takes, all of it: the scan's beams, motion, update,
// estimate.
//   ./flow_bench [--benchmark_filter=step/naedh/cpu/particles:100] [--benchmark_repetitions=5]
// The place is that of stage_bench: the hall with obstacles, an 8 m LiDAR of 270 degrees, a scan simulated
// against the map of 1 cm; 360 of its beams. The robot goes to and fro by 5 cm, so that every iteration has
// motion and starts near where the one before began. RayWall clock.

#include "common/config/config.h"
#include "common/config/pose_filters.h"
#include "common/flow/flow_filter.h"
#include "common/model/beams.h"
#include "tests/bench/bench_hall.h"

namespace {

using namespace parloc;
using namespace parloc::bench;

const Place& hall() {
  static const Place place = hall_with_scan(360);
  return place;
}

void step(benchmark::State& state, const std::string& name, BackendChoice backend, std::int64_t particles,
          int threads) {
  const Place& place = hall();
  Config config;
  config.backend = backend;
  config.particles = particles;
  config.threads = threads;
  const auto filter = make_pose_filter(name, config, place.map);
  filter->start_at(place.pose, 0.05, 0.05, 0.02);
  bool forward = false;
  for (auto _ : state) {
    forward = !forward;
    benchmark::DoNotOptimize(filter->step({forward ? 0.05 : 0.0, 0.0, 0.0}, place.scan));
  }
  if (!filter->why_skipped().empty()) state.SkipWithError(filter->why_skipped().c_str());
  count(state, "steps/s", 1.0);
  state.SetLabel(filter->backend_name());
}

/// What the host does before any of it, with the directions of the beams remembered or not.
void beams(benchmark::State& state, bool remembered) {
  const Place& place = hall();
  ScanConfig config;
  config.max_beams = 360;
  BeamTable table;
  BeamCounts counts;
  BeamDirections directions;
  const LidarSetup setup = lidar_setup(place.scan, config);
  for (auto _ : state) {
    select_beams(place.scan, setup, nullptr, SensorConfig{}, place.map.resolution_m, table, counts,
                 remembered ? &directions : nullptr);
    benchmark::DoNotOptimize(table.end_x.data());
  }
}

void add(const std::string& name, BackendChoice backend, std::int64_t particles, int threads) {
  std::string full = "step/" + name + (backend == BackendChoice::cpu ? "/cpu" : "/cuda") +
                     "/particles:" + std::to_string(particles);
  if (backend == BackendChoice::cpu) full += "/threads:" + std::to_string(threads);
  benchmark::RegisterBenchmark(
      full.c_str(), [=](benchmark::State& state) { step(state, name, backend, particles, threads); })
      ->UseRealTime()
      ->Unit(benchmark::kMicrosecond);
}

void add_backend(BackendChoice backend, int threads) {
  for (const char* name : {"ekf", "ekf_beams"}) add(name, backend, 1, threads);
  for (const std::int64_t particles : {10, 100, 1000, 10'000, 100'000, 1'000'000})
    for (const char* name : {"edh", "naedh", "gromov"}) add(name, backend, particles, threads);
  for (const std::int64_t particles : {10, 100, 1000})
    for (const char* name : {"ledh", "pfpf"}) add(name, backend, particles, threads);
}

}  // namespace

int main(int argc, char** argv) {
  return run_benchmarks(argc, argv, [] {
    for (const bool remembered : {false, true})
      benchmark::RegisterBenchmark(remembered ? "beams/remembered" : "beams",
                                   [=](benchmark::State& state) { beams(state, remembered); })
          ->UseRealTime()
          ->Unit(benchmark::kMicrosecond);
    for (const int threads : {1, 2}) add_backend(BackendChoice::cpu, threads);
    if (cuda_answers()) add_backend(BackendChoice::cuda, 1);
  });
}
