// The subcommands of `parloc log`, one file each, and what they have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "tools/program/commands.h"

namespace parloc::tools {

/// Which log, and what of a bag is read.
struct LogArguments : ConfigOptions {
  std::string log;
};

/// LOG, the options that choose among a bag's topics and frames, and --config.
void add_log_argument(CLI::App& app, LogArguments& arguments);

Command add_log_info(CLI::App& log);
Command add_log_convert(CLI::App& log);

}  // namespace parloc::tools
