// parloc log convert: any log as MCAP or CARMEN text.
#include <CLI/CLI.hpp>
#include <string>

#include "common/error.h"
#include "tools/log/log.h"

namespace parloc::tools {
namespace {

struct ConvertOptions : LogArguments {
  std::string output;
};

void declare(CLI::App& app, ConvertOptions& o) {
  add_log_argument(app, o);
  add_text_option(app, "--output", o.output, "OUT", "OUT.mcap (ROS 2), or OUT.log (CARMEN)")->required();
}

int convert(const ConvertOptions& o, const std::string&) {
  throw Error(ErrorKind::usage, o.output + ": expected a name that ends in .mcap or .log");
}

}  // namespace

Command add_log_convert(CLI::App& log) {
  return add_command<ConvertOptions>(log, "convert", "Write a log as MCAP or CARMEN", declare, convert);
}

}  // namespace parloc::tools
