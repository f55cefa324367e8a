// parloc config: the effective configuration, every key with its meaning.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "tools/program/commands.h"
#include "tools/program/text_option.h"

namespace parloc::tools {

Command add_config_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("config", "Print the effective configuration, with every default");
  const auto path = std::make_shared<std::string>();
  add_text_option(*app, "--config", *path, "C.yaml", "Configuration to read over the defaults");
  return {app, [path] {
            const Config config = path->empty() ? Config{} : read_config(*path);
            std::fputs(config_to_yaml(config).c_str(), stdout);
            return 0;
          }};
}

}  // namespace parloc::tools
