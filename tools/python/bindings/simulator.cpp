// Drives with exact truth.
#include "common/simulator/simulator.h"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <filesystem>
#include <optional>

#include "common/file/output_file.h"
#include "common/map/map_reader.h"
#include "common/simulator/scenario.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/log_scans.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

struct Simulation {
  std::string text;  ///< The log.
  SimulatedLog drive;
};

Simulation simulate_drive(const std::filesystem::path& path, std::optional<std::uint64_t> seed,
                          const GridMap* map) {
  const nb::gil_scoped_release others_run;
  Scenario scenario = read_scenario(path.string());
  if (seed) scenario.seed = *seed;
  Simulation made;
  made.drive = simulate(scenario, map != nullptr ? *map : read_map(scenario.map_path), [](double) {
    const nb::gil_scoped_acquire ours;
    heed_signals();
    return true;
  });
  made.text = carmen_text(made.drive);
  made.drive.records.clear();
  return made;
}

Log log_of(const Simulation& made) {
  return {"simulated log", Config(), [text = made.text](const Config& config) {
            return carmen_log_from_text(text, "simulated log", log_choice(config).without_odometry);
          }};
}

}  // namespace

void bind_simulator(nb::module_& m) {
  nb::class_<Simulation>(m, "Simulation",
                         "A simulated drive: what the robot recorded, and where it truly was.")
      .def_prop_ro("log", &log_of,
                   "The log, as `parloc simulate` writes it: localizing either gives the same bits.")
      .def_prop_ro(
          "truth", [](const Simulation& s) { return array_of(Trajectory(s.drive.truth)); }, kOwnArray,
          "float64 array of shape (N, 4): rows of (stamp_s, x_m, y_m, theta_rad) in the map frame, one per "
          "scan.")
      .def_prop_ro(
          "path_length_m", [](const Simulation& s) { return s.drive.path_length_m; }, "Length driven [m].")
      .def_prop_ro(
          "duration_s", [](const Simulation& s) { return s.drive.duration_s; }, "Time taken [s].")
      .def_prop_ro(
          "beams", [](const Simulation& s) { return s.drive.beams; }, "All beams of all scans.")
      .def_prop_ro(
          "hits", [](const Simulation& s) { return s.drive.hits; }, "Those that hit something.")
      .def_prop_ro(
          "unmapped", [](const Simulation& s) { return s.drive.unmapped; },
          "Of the hits, those on something that is not on the map.")
      .def(
          "save",
          [](const Simulation& s, const std::filesystem::path& path) {
            const nb::gil_scoped_release others_run;
            replace_file(path.string(), s.text);
          },
          "path"_a, "Writes the log as CARMEN text. Raises OutputError.");
  m.def("simulate", &simulate_drive, "scenario"_a, "seed"_a = nb::none(), "map"_a.none() = nb::none(),
        "Simulates the drive of a scenario, a YAML file with LiDAR, odometry, map and path "
        "(docs/simulator.md): equal "
        "scenarios and seeds give equal bytes on every machine. `map`: cast rays against this one instead. "
        "Raises "
        "ConfigError, InputError if the path leaves the map.");
}

}  // namespace parloc::python
