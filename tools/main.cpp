// The `parloc` program: picks the subcommand, and turns every error into one line and an exit code.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "common/error.h"
#include "tools/program/commands.h"
#include "tools/program/typed_command.h"

namespace parloc::tools {
namespace {

/// Starts the program anew with a short wait, once, unless the environment says how to wait. GNU OpenMP spins
/// for about 3 ms otherwise. On a machine that is busy with something else, a thread that spins keeps the
/// core from the very thread it waits for: steps of 1 ms then take 4 to 8. The setting is read when the
/// library is loaded, so only the environment can give it. Returns if there is nothing to do or it cannot be
/// done.
void wait_briefly(char** argv) {
  constexpr const char* kSpins = "3000";  // about 0.03 ms
  if (std::getenv("GOMP_SPINCOUNT") != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  if (setenv("GOMP_SPINCOUNT", kSpins, 1) != 0) return;
  execv("/proc/self/exe", argv);
}

/// One line on stderr, whatever file names and libraries put into `message`.
int complain(std::string message, ErrorKind kind) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  fmt::print(stderr, "parloc: {}\n", message);
  return static_cast<int>(kind);
}

int run_program(const std::vector<std::string>& words) {
  CLI::App program("Localizes a mobile robot with a 2D LiDAR on a known map.", "parloc");
  program.set_version_flag("--version", "parloc " PARLOC_VERSION);
  program.require_subcommand(1);
  program.get_formatter()->column_width(26);
  program.get_formatter()->label("REQUIRED", "(needed)");
  program.footer("parloc COMMAND --help explains a command. Exit codes: docs/exit_codes.md");
  std::vector<Command> commands;
  for (const auto add :
       {add_run_command, add_simulate_command, add_learn_command, add_locate_command, add_map_command,
        add_log_command, add_config_command, add_evaluate_command, add_compare_command, add_slam_command,
        add_bench_command, add_devices_command, add_sweep_command, add_tune_command})
    commands.push_back(add(program));
  commands.push_back(add_merge_command(program, run_program));
  program.get_help_ptr()->group("");  // whoever reads the list knows it; commands inherit what is not hidden
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  try {
    program.parse(static_cast<int>(argv.size()), argv.data());
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return program.exit(e);  // --help, --version
    std::string where = "parloc";
    for (const Command& command : commands) {
      if (command.app->parsed()) where += " " + command.app->get_name();
    }
    return complain(fmt::format("{} (see {} --help)", e.what(), where), ErrorKind::usage);
  }
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.run(typed_command(words));
  }
  return complain("expected a command (see parloc --help)", ErrorKind::usage);
}

}  // namespace
}  // namespace parloc::tools

int main(int argc, char** argv) {
  using parloc::ErrorKind;
  using parloc::tools::complain;
  parloc::tools::wait_briefly(argv);
  try {
    const int code = parloc::tools::run_program({argv, argv + argc});
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      return complain("standard output cannot be written", ErrorKind::output);
    }
    return code;
  } catch (const parloc::Error& e) {
    return complain(e.what(), e.kind());
  } catch (const std::bad_alloc&) {
    return complain("out of memory", ErrorKind::internal);
  } catch (const std::exception& e) {
    return complain(fmt::format("internal error: {}", e.what()), ErrorKind::internal);
  }
}
