// The subcommands of the program, one file each, and what these have in common: options, settings, exit
// codes.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/filter/filter_settings.h"
#include "common/math/pose.h"
#include "common/settings/setting.h"

namespace parloc::tools {

/// A subcommand: its place in the command line, and what it does once that is parsed. `run` is told the whole
/// command line as typed, for the results, and gives the exit code (docs/exit_codes.md); it throws
/// parloc::Error.
struct Command {
  CLI::App* app;
  std::function<int(const std::string& typed)> run;
};

Command add_run_command(CLI::App& program);
Command add_simulate_command(CLI::App& program);
Command add_learn_command(CLI::App& program);
Command add_locate_command(CLI::App& program);
Command add_map_command(CLI::App& program);
Command add_log_command(CLI::App& program);
Command add_config_command(CLI::App& program);
Command add_bench_command(CLI::App& program);
Command add_evaluate_command(CLI::App& program);
Command add_compare_command(CLI::App& program);
Command add_slam_command(CLI::App& program);
Command add_devices_command(CLI::App& program);
Command add_sweep_command(CLI::App& program);
Command add_tune_command(CLI::App& program);
/// `run_words` runs another command line of the program.
Command add_merge_command(CLI::App& program,
                          const std::function<int(const std::vector<std::string>& words)>& run_words);

/// Exit code of a search that found no place on the map, and of a strict run that does not know its place at
/// the end; no error.
inline constexpr int kExitNotFound = 7;

/// Exit code of a run that was interrupted and wrote what it had: 128 + SIGINT, as shells have it.
inline constexpr int kExitInterrupted = 130;

/// A command whose words are kept in an `Options`, as `declare` says, and given to `run`.
template <class Options>
Command add_command(CLI::App& program, const char* name, const char* help,
                    void (*declare)(CLI::App&, Options&),
                    int (*run)(const Options&, const std::string& typed)) {
  CLI::App* app = program.add_subcommand(name, help);
  const auto options = std::make_shared<Options>();
  declare(*app, *options);
  return {app, [=](const std::string& typed) { return run(*options, typed); }};
}

/// `Text` is std::string, or a vector of them for an option that may come again. `value_name` stands for the
/// value in the help. An empty value, such as an unset variable of a script leaves, is an error rather than
/// the default.
template <class Text>
CLI::Option* add_text_option(CLI::App& app, const std::string& name, Text& target,
                             const std::string& value_name, const std::string& help) {
  const CLI::Validator not_empty(
      [](std::string& text) {
        return text.empty() ? std::string("expected a value, got nothing") : std::string();
      },
      "");
  return app.add_option(name, target, help)->type_name(value_name)->check(not_empty);
}

/// Refuses words other than these, which the message names; the help does not repeat them.
inline CLI::Validator one_of(const std::vector<std::string>& words) {
  return CLI::Validator(CLI::IsMember(words)).description("");
}

/// `value_name` stands for the word in the help. CLI11 refuses every other word and names these.
template <class Enum>
CLI::Option* add_choice_option(CLI::App& app, const std::string& name, std::optional<Enum>& target,
                               const std::vector<Choice<Enum>>& choices, const std::string& value_name,
                               const std::string& help) {
  std::vector<std::string> words;
  for (const Choice<Enum>& choice : choices) words.emplace_back(choice.name);
  const auto take = [&target, choices](const std::string& word) {
    for (const Choice<Enum>& choice : choices)
      if (word == choice.name) target = choice.value;
  };
  return app.add_option_function<std::string>(name, take, help)->type_name(value_name)->check(one_of(words));
}

/// Each a line on standard error: what an input says that is not used, or not as it stands.
void print_notes(const std::vector<std::string>& notes);

/// The options of several commands that set something in the configuration; empty: not given.
struct ConfigOptions {
  std::string config, device, threads, seed, beams;
  std::vector<std::string> scan_topics;                    // of a bag
  std::string odometry_topic, odometry_frame, base_frame;  // of a bag
  std::string map_topic, truth_topic, truth_frame;         // of a bag
  std::optional<BackendChoice> backend;
};

/// Puts what the options of add_log_options() say into the configuration.
void say_of_log(Config& config, const ConfigOptions& options);
/// Where the map is: where --map says, else in the log, if that is a bag. Throws Error{usage} if it is none.
std::string map_or_log(const std::string& map, const std::string& log);
/// Where the true poses are: where --truth says, else in the log, if its topic or frame is said; else
/// nowhere.
std::string truth_or_log(const std::string& truth, const std::string& log, const Config& config);

/// --log LOG, and the options for what is read of a bag, which its errors name and docs/bags.md explains.
CLI::Option* add_log_options(CLI::App& app, ConfigOptions& options, std::string& log,
                             const std::string& help = "CARMEN log, or bag of ROS 1 or 2 (parloc log info)");

/// The setting of that name becomes what the option says, within the limits that the settings' table gives
/// it; false if the option was not given. Throws Error{usage} naming `option`.
bool set_whole_number(Config& config, const std::string& name, const char* option, const std::string& text);

/// The configuration file over `base`, the options on top, and then what else the command sets in it by
/// `change`. `start` becomes what a file of nav2 says of it. Throws Error{config} for the file, Error{usage}
/// for what is on top. Prints two or three lines about a file of nav2 on standard error.
Config effective_config(const ConfigOptions& options, const std::function<void(Config&)>& change = {},
                        const Config& base = {}, std::optional<Pose>* start = nullptr);

}  // namespace parloc::tools
