// parloc devices: what this build can run on, here.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "common/filter/filter_backend.h"
#include "tools/program/commands.h"

namespace parloc::tools {

Command add_devices_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("devices", "List the CPU and the CUDA devices that parloc can use");
  return {app, [] {
            for (const std::string& line : describe_devices()) std::printf("%s\n", line.c_str());
            return 0;
          }};
}

}  // namespace parloc::tools
