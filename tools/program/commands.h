// The subcommands of the program, one file each.
#pragma once

#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace parloc::tools {

/// A subcommand: its place in the command line, and what it does once that is parsed. `run` gives the exit
/// code (docs/exit_codes.md); it throws parloc::Error.
struct Command {
  CLI::App* app;
  std::function<int()> run;
};

/// `typed` is the whole command line, for the report.
Command add_run_command(CLI::App& program, const std::string& typed);
Command add_simulate_command(CLI::App& program);
/// `typed` is the whole command line, for the block that it prints.
Command add_learn_command(CLI::App& program, const std::string& typed);
Command add_locate_command(CLI::App& program);
Command add_map_command(CLI::App& program);
Command add_config_command(CLI::App& program);
/// `typed` is the whole command line, for the results.
Command add_bench_command(CLI::App& program, const std::string& typed);
/// `typed` is the whole command line, for the results.
Command add_evaluate_command(CLI::App& program, const std::string& typed);
/// `typed` is the whole command line, for the results.
Command add_compare_command(CLI::App& program, const std::string& typed);
/// `typed` is the whole command line, for the results.
Command add_slam_command(CLI::App& program, const std::string& typed);
Command add_devices_command(CLI::App& program);

/// Exit code of a search that found no place on the map, and of a strict run that does not know its place at
/// the end; no error.
inline constexpr int kExitNotFound = 7;

/// Exit code of a run that was interrupted and wrote what it had: 128 + SIGINT, as shells have it.
inline constexpr int kExitInterrupted = 130;

}  // namespace parloc::tools
