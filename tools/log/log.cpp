// parloc log: what is in a log, and the same in another format.
#include "tools/log/log.h"

#include <vector>

namespace parloc::tools {

void add_log_argument(CLI::App& app, LogArguments& o) {
  add_text_option(app, "LOG", o.log, "LOG", "CARMEN log, or bag of ROS 1 or 2")->required();
  add_text_option(app, "--scan-topic", o.scan_topics, "TOPIC", "Scans of a bag; again: several LiDARs")
      ->allow_extra_args(false);
  add_text_option(app, "--odom-topic", o.odometry_topic, "TOPIC", "Odometry of a bag");
  add_text_option(app, "--odom-frame", o.odometry_frame, "FRAME", "Its transforms are the odometry (odom)");
  add_text_option(app, "--base-frame", o.base_frame, "FRAME", "The robot's (the odometry's child)");
  add_text_option(app, "--config", o.config, "C.yaml", "Settings: where LiDARs sit, which topics count");
}

Command add_log_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("log", "What is in a log, and the same in another format");
  app->require_subcommand(1);
  std::vector<Command> subcommands;
  for (const auto add : {add_log_info, add_log_convert}) subcommands.push_back(add(*app));
  return {app, [=](const std::string& typed) {
            for (const Command& command : subcommands)
              if (command.app->parsed()) return command.run(typed);
            return 0;
          }};
}

}  // namespace parloc::tools
