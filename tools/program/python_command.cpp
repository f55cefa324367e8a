// Commands that the Python package executes, as git has it with its own: the words are passed on.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "common/error.h"
#include "tools/program/commands.h"
#include "tools/program/typed_command.h"

namespace parloc::tools {
namespace {

namespace fs = std::filesystem;

/// As execvp() wants them.
std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// Whether that Python has the module. Its package is looked up and not loaded, which would take longer.
bool has_module(const std::string& python, const std::string& package, const std::string& module) {
  const std::string look =
      "import importlib.util as u, os, sys\n"
      "s = u.find_spec(sys.argv[1])\n"
      "p = [os.path.join(f, sys.argv[2]) for f in (s.submodule_search_locations if s else [])]\n"
      "sys.exit(not any(map(os.path.exists, p)))";
  std::vector<std::string> words{python, "-c", look, package, module};
  posix_spawn_file_actions_t silent;
  posix_spawn_file_actions_init(&silent);
  posix_spawn_file_actions_addopen(&silent, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child{};
  const bool begun =
      posix_spawnp(&child, python.c_str(), &silent, nullptr, pointers_to(words).data(), environ) == 0;
  posix_spawn_file_actions_destroy(&silent);
  int status = 0;
  return begun && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Becomes `python3 -m parloc.MODULE` with the words after the command. The Python beside the program comes
/// first: in an environment of Python's they belong together.
int run_in_python(const std::string& module, const std::string& typed) {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const std::vector<std::string> typed_words = words_of(typed);
  for (const std::string& python : {(program.parent_path() / "python3").string(), std::string("python3")}) {
    if (!has_module(python, "parloc", module)) continue;
    std::vector<std::string> words{python, "-m", "parloc." + module};
    words.insert(words.end(), typed_words.begin() + 2, typed_words.end());
    setenv("PARLOC_PROGRAM", program.c_str(), 1);  // the one that Python calls in turn
    execvp(python.c_str(), pointers_to(words).data());
    throw Error(ErrorKind::backend, fmt::format("{}: cannot be started: {}", python, std::strerror(errno)));
  }
  throw Error(ErrorKind::backend,
              fmt::format("{} is done in Python: expected a python3 on PATH that has the package parloc with "
                          "parloc.{} (pip install . in parloc's sources)",
                          typed_words[1], module));
}

Command add_python_command(CLI::App& program, const char* name, const char* help, const char* module) {
  CLI::App* app = program.add_subcommand(name, help);
  app->set_help_flag();
  app->prefix_command();
  return {app, [module](const std::string& typed) { return run_in_python(module, typed); }};
}

}  // namespace

Command add_sweep_command(CLI::App& program) {
  return add_python_command(program, "sweep", "Trials over ranges of settings, on many machines", "sweeps");
}

Command add_tune_command(CLI::App& program) {
  return add_python_command(program, "tune", "Settings for a robot from its drives: are they better?",
                            "tuning");
}

}  // namespace parloc::tools
