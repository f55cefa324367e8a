// What the kernels of one full step do, counted on PTX: for the model of its time
// (tools/studies/gpu_model.py).
//   count_step SCENARIO MODEL PARTICLES BEAMS      prints JSON
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "common/filter/map_frame.h"
#include "common/filter/start.h"
#include "common/map/map_reader.h"
#include "common/model/beams.h"
#include "common/model/model_settings.h"
#include "common/simulator/simulator.h"
#include "tests/ptx/counted.h"

namespace {

using namespace parloc;

SensorModel model_named(const std::string& name) {
  for (const Choice<SensorModel>& choice : kSensorModels)
    if (choice.name == name) return choice.value;
  throw Error(ErrorKind::usage, "no sensor model '" + name + "'");
}

/// A filter that tracks its robot, half-way through a drive: four steps are taken, and the last is counted.
void count(const std::string& scenario_path, SensorModel model, std::int64_t particles, int beams) {
  Scenario scenario = read_scenario(scenario_path);
  scenario.lidar.dropout_probability = 0.0;  // so that every selected beam is used
  const GridMap map = read_map(scenario.map_path);
  const SimulatedLog log = simulate(scenario, map, [](double fraction) { return fraction < 0.5; });
  const Pose pose = log.truth.back().pose;
  Scan scan;
  for (const LogRecord& record : log.records)
    if (record.kind == RecordKind::scan) scan = record.scan;

  FilterBackendConfig config{.particles = particles, .sensor = default_sensor(model)};
  std::string why;
  const auto backend = make_filter_backend(BackendChoice::cuda, config, why);
  const GridMap known = read_map(scenario.localization_map_path);
  backend->set_map(known);
  BeamTable table;
  BeamCounts counts;
  ScanConfig scan_config;
  scan_config.max_beams = beams;
  select_beams(scan, scan_config, config.sensor, known.resolution_m, table, counts);
  backend->set_range_max(table.range_max_m);
  backend->upload(gaussian_start(known, pose, 0.05, 0.05, 0.02, particles, 1));
  for (std::uint32_t step = 0; step < 4; ++step) {
    ptx::forget_counts();
    backend->predict({0.0f, 0.0f, 0.0f, 0.01f, 0.01f, 0.01f}, {1, step});
    backend->set_scan(table);
    backend->weight(true);
    backend->normalise_scan();
    backend->estimate();
    backend->resample({1, step});
    backend->finish();
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    fmt::print(stderr, "usage: count_step SCENARIO MODEL PARTICLES BEAMS\n");
    return 2;
  }
  try {
    count(argv[1], model_named(argv[2]), std::atoll(argv[3]), std::atoi(argv[4]));
    fmt::print("{}\n", test::counted().dump(1));
  } catch (const Error& error) {
    fmt::print(stderr, "count_step: {}\n", error.what());
    return static_cast<int>(error.kind());
  }
}
