#include "tools/program/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <variant>

#include "common/bag/open_bag.h"
#include "common/config/config.h"
#include "common/config/config_settings.h"
#include "common/config/nav2_config.h"
#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "tools/program/parse_number.h"

namespace parloc::tools {

bool set_whole_number(Config& config, const std::string& name, const char* option, const std::string& text) {
  if (text.empty()) return false;
  for (const Setting& setting : settings_of(config).all) {
    if (setting.name() != name) continue;
    std::visit(
        [&]<class Value>(const Value& value) {
          if constexpr (requires {
                          value.slot.get();
                          value.limits;
                        })
            value.slot.set(parse_whole_number(option, text, value.limits.low, value.limits.high));
        },
        setting.value);
  }
  return true;
}

CLI::Option* add_log_options(CLI::App& app, ConfigOptions& o, std::string& log, const std::string& help) {
  CLI::Option* option = add_text_option(app, "--log", log, "LOG", help);
  add_text_option(app, "--scan-topic", o.scan_topics, "TOPIC", "Scans of a bag; again: several LiDARs")
      ->allow_extra_args(false)
      ->group("");
  add_text_option(app, "--odom-topic", o.odometry_topic, "TOPIC", "Odometry of a bag")->group("");
  add_text_option(app, "--odom-frame", o.odometry_frame, "FRAME", "Its transforms are the odometry (odom)")
      ->group("");
  add_text_option(app, "--map-topic", o.map_topic, "TOPIC", "The map of a bag")->group("");
  add_text_option(app, "--truth-topic", o.truth_topic, "TOPIC", "True poses of a bag")->group("");
  add_text_option(app, "--truth-frame", o.truth_frame, "FRAME", "True poses: of the robot in it, by /tf")
      ->group("");
  add_text_option(app, "--base-frame", o.base_frame, "FRAME", "The robot's (the odometry's child)")
      ->group("");
  return option;
}

std::string map_or_log(const std::string& map, const std::string& log) {
  if (!map.empty()) return map;
  if (is_bag(log)) return log;
  throw Error(ErrorKind::usage, "expected --map M.yaml: only a bag may have its map in it");
}

std::string truth_or_log(const std::string& truth, const std::string& log, const Config& config) {
  const bool in_log = !config.log.truth_topic.empty() || !config.log.truth_frame.empty();
  return truth.empty() && in_log ? log : truth;
}

void print_notes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) std::fprintf(stderr, "parloc: note: %s\n", note.c_str());
}

void say_of_log(Config& config, const ConfigOptions& o) {
  const auto say = [](std::string& setting, const std::string& option) {
    if (!option.empty()) setting = option;
  };
  say(config.log.scan_topic, fmt::format("{}", fmt::join(o.scan_topics, ",")));
  say(config.log.odometry_topic, o.odometry_topic);
  say(config.log.odometry_frame, o.odometry_frame);
  say(config.log.base_frame, o.base_frame);
  say(config.log.map_topic, o.map_topic);
  say(config.log.truth_topic, o.truth_topic);
  say(config.log.truth_frame, o.truth_frame);
}

Config effective_config(const ConfigOptions& o, const std::function<void(Config&)>& change,
                        const Config& base, std::optional<Pose>* start) {
  const ConfigFile file = o.config.empty() ? ConfigFile{base, {}, {}, {}} : read_config_file(o.config, base);
  print_notes(nav2_summary(file, o.config));
  if (start != nullptr) *start = file.nav2_start;
  Config config = file.config;
  set_whole_number(config, "seed", "--seed", o.seed);
  set_whole_number(config, "device", "--device", o.device);
  set_whole_number(config, "threads", "--threads", o.threads);
  if (set_whole_number(config, "scan.max_beams", "--beams", o.beams)) {
    config.scan.min_beams =
        std::min(config.scan.min_beams, config.scan.max_beams);  // so few are meant to be used
  }
  if (o.backend) config.backend = *o.backend;
  say_of_log(config, o);
  if (change) change(config);
  try {
    validate(config);
  } catch (const Error& e) {  // a file is sound by now, so it is the command line
    throw Error(ErrorKind::usage, e.what());
  }
  return config;
}

/// `parloc config`: the effective configuration, every key with its meaning.
Command add_config_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("config", "Print the effective configuration, with every default");
  const auto path = std::make_shared<std::string>();
  add_text_option(*app, "--config", *path, "C.yaml", "Configuration to read over the defaults");
  return {app, [path](const std::string&) {
            const ConfigFile file = path->empty() ? ConfigFile{} : read_config_file(*path);
            if (!file.nav2_node.empty())
              std::printf(
                  "# Translated from the parameters of %s; what they do not say is parloc's default. "
                  "docs/nav2.md\n",
                  printable(file.nav2_node).c_str());
            for (const std::string& line : nav2_listing(file)) std::printf("# %s\n", line.c_str());
            std::fputs(config_to_yaml(file.config).c_str(), stdout);
            return 0;
          }};
}

/// `parloc devices`: what this build can run on, here.
Command add_devices_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("devices", "List the CPU and the CUDA devices that parloc can use");
  return {app, [](const std::string&) {
            for (const std::string& line : describe_devices()) std::printf("%s\n", line.c_str());
            return 0;
          }};
}

}  // namespace parloc::tools
