// parloc simulate: a log with noise, and the truth beside it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/file/output_file.h"
#include "common/io/trajectory.h"
#include "common/map/map_reader.h"
#include "common/simulator/scenario.h"
#include "common/simulator/simulator.h"
#include "tools/program/commands.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"

namespace parloc::tools {
namespace {

struct SimulateOptions {
  std::string scenario, map, path, seed;
  std::string out = "parloc_simulated";
  bool quiet = false;
};

void declare(CLI::App& app, SimulateOptions& o) {
  add_text_option(app, "--scenario", o.scenario, "S.yaml", "LiDAR, odometry, map and path");
  add_text_option(app, "--map", o.map, "M.yaml", "Cast rays against this map instead");
  add_text_option(app, "--path", o.path, "P.yaml", "Drive this path of waypoints instead");
  add_text_option(app, "--seed", o.seed, "S", "Same seed, same log");
  add_text_option(app, "--out", o.out, "DIR", "Folder for the log (parloc_simulated)");
  app.add_flag("--quiet", o.quiet, "No progress and no summary");
  app.footer(
      "Writes scans.log (CARMEN) and truth.tum. Without a scenario, --map and --path\n"
      "are needed; examples: configs/*_scenario.yaml, explained in docs/simulator.md.");
}

Scenario effective_scenario(const SimulateOptions& o) {
  if (o.scenario.empty() && (o.map.empty() || o.path.empty())) {
    throw Error(ErrorKind::usage, "simulate: give --scenario, or --map and --path");
  }
  Scenario scenario = o.scenario.empty() ? Scenario{} : read_scenario(o.scenario);
  if (!o.map.empty()) scenario.map_path = scenario.localization_map_path = o.map;
  if (!o.path.empty()) {
    scenario.path_file = o.path;
    scenario.path = read_waypoints(o.path);
  }
  if (!o.seed.empty()) scenario.seed = parse_whole_number<std::uint64_t>("--seed", o.seed);
  return scenario;
}

SimulatedLog simulate_with_progress(const Scenario& scenario, const GridMap& map, bool quiet) {
  Progress progress(quiet);
  return simulate(scenario, map, [&](double fraction) {
    progress.update(fraction);
    return !interrupted();
  });
}

std::size_t scans_in(const SimulatedLog& log) {
  const auto is_scan = [](const LogRecord& record) { return record.kind == RecordKind::scan; };
  return static_cast<std::size_t>(std::count_if(log.records.begin(), log.records.end(), is_scan));
}

/// What the filter must be told, since a CARMEN log cannot say it; one line per LiDAR, as its configuration
/// has it.
void print_unsaid(const Scenario& scenario) {
  std::vector<SimulatedLidar> lidars{scenario.lidar};
  lidars.insert(lidars.end(), scenario.more_lidars.begin(), scenario.more_lidars.end());
  for (std::size_t k = 0; k < lidars.size(); ++k) {
    const SimulatedLidar& lidar = lidars[k];
    std::string unsaid = lidar.upside_down ? "upside_down: true" : "";
    if (lidar.scan_time_s > 0.0) {
      const char* at = lidar.stamp_at == StampAt::first    ? "first"
                       : lidar.stamp_at == StampAt::middle ? "middle"
                                                           : "last";
      unsaid +=
          fmt::format("{}scan_time: {}, stamp_at: {}", unsaid.empty() ? "" : ", ", lidar.scan_time_s, at);
    }
    if (unsaid.empty()) continue;
    fmt::print(
        "{:<12}the log cannot say it, the filter's configuration must: lidars: {{robotlaser{}: {{{}}}}}\n",
        "note", k + 1, unsaid);
  }
}

int run(const SimulateOptions& o, const std::string&) {
  const Scenario scenario = effective_scenario(o);
  const GridMap map = read_map(scenario.map_path);
  OutputFolder out(o.out, {"scans.log", "truth.tum"});
  catch_interrupts();
  const SimulatedLog log = simulate_with_progress(scenario, map, o.quiet);
  replace_file(out.staged("scans.log"), carmen_text(log));
  write_tum(out.staged("truth.tum"), log.truth);
  out.publish();
  const int code = interrupted() ? kExitInterrupted : 0;
  if (o.quiet) return code;
  fmt::print("{:<12}{:.1f} m in {:.1f} s, {} scans, seed {}\n", "drive", log.path_length_m, log.duration_s,
             scans_in(log), scenario.seed);
  fmt::print("{:<12}{} of {} hit, {} without a wall in reach, {} dropped out\n", "beams", log.hits, log.beams,
             log.over_range, log.dropouts);
  if (log.unmapped > 0) {
    fmt::print("{:<12}{:.1f} % of the hits are on people and boxes that are not on the map\n", "clutter",
               100.0 * static_cast<double>(log.unmapped) / static_cast<double>(log.hits));
  }
  fmt::print("{:<12}{} (beside it: truth.tum)\n", "log", out.final_path("scans.log"));
  print_unsaid(scenario);
  if (!scenario.localization_map_path.empty()) {
    fmt::print("{:<12}parloc run --map {} --log {} --truth {}\n", "localize it",
               scenario.localization_map_path, out.final_path("scans.log"), out.final_path("truth.tum"));
  }
  return code;
}

}  // namespace

Command add_simulate_command(CLI::App& program) {
  return add_command<SimulateOptions>(program, "simulate",
                                      "Make a log with exact truth from a map and a path", declare, run);
}

}  // namespace parloc::tools
