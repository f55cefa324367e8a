// parloc log info: what is in a log, and the command line that would run it.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/bag/open_bag.h"
#include "common/config/config.h"
#include "common/error.h"
#include "common/inputs/open_log.h"
#include "tools/log/info_text.h"
#include "tools/log/log.h"
#include "tools/program/progress.h"

namespace parloc::tools {
namespace {

struct InfoOptions : LogArguments {
  bool json = false, quiet = false;
};

void declare(CLI::App& app, InfoOptions& o) {
  add_log_argument(app, o);
  app.add_flag("--json", o.json, "The same as JSON, for programs");
  app.add_flag("--quiet", o.quiet, "No progress");
}

/// Topic by topic, and what of it to read.
void look_at_bag(LogInfo& info, LogChoice& choice, Progress& progress) {
  const auto bag = open_bag(info.path);
  info.bag = survey_bag(
      *bag, [&](double part) { progress.update(0.5 * part, "topics"); }, interrupted);
  info.suggested = suggest_choice(*info.bag, choice);
  choice = info.suggested.choice;
}

int run(const InfoOptions& o, const std::string&) {
  const Config config = effective_config(o);
  LogChoice choice = log_choice(config);
  LogInfo info;
  info.path = o.log;
  info.lidars = config.lidars;
  const bool bag = is_bag(o.log);
  catch_interrupts();
  {
    Progress progress(o.quiet || o.json);
    if (bag) look_at_bag(info, choice, progress);
    const double done = bag ? 0.5 : 0.0;
    try {
      const std::unique_ptr<LogReader> log = open_log(o.log, choice);
      info.log = survey_log(
          *log, config.lidars, [&](double part) { progress.update(done + (1.0 - done) * part, "scans"); },
          interrupted);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input || !bag) throw;
      info.trouble = error.what();  // what there is in the bag is worth a look all the same
    }
  }
  std::fputs((o.json ? info_json(info) : info_text(info)).c_str(), stdout);
  if (interrupted()) return kExitInterrupted;
  if (!info.trouble.empty()) throw Error(ErrorKind::input, info.trouble);
  return 0;
}

}  // namespace

Command add_log_info(CLI::App& log) {
  return add_command<InfoOptions>(log, "info", "What is in a log, and how to run it", declare, run);
}

}  // namespace parloc::tools
