// Every setting that there is: what a configuration file holds, and what each filter reads of it.
#pragma once

#include <string>

#include "common/flow/flow_filter_config.h"
#include "common/io/log_choice.h"
#include "common/localize/localizer_config.h"
#include "common/slam/grid_slam_config.h"

namespace parloc {

/// The localizer's settings, which are at the top, and those that flows and SLAM have besides or in place of
/// them.
struct Config : LocalizerConfig {
  FlowConfig flow;                                           ///< Of Kalman filters and particle flows.
  int flow_max_beams = FlowFilterConfig().scan.max_beams;    ///< flow.max_beams
  LogChoice log;                                             ///< Without what log_choice() adds.
  SlamConfig slam;                                           ///< Of mapping.
  int slam_max_beams = GridSlamConfig().scan.max_beams;      ///< slam.max_beams
  double slam_update_min_d = GridSlamConfig().update_min_d;  ///< slam.update_min_d [m]
  double slam_update_min_a = GridSlamConfig().update_min_a;  ///< slam.update_min_a [rad]
};

/// Flows take every scan, whatever update_min_d and update_min_a say.
FlowFilterConfig flow_filter_config(const Config& config);
/// What GridSlam reads of all settings, with the scans, beams and thresholds that mapping has of its own.
GridSlamConfig grid_slam_config(const Config& config);
/// Whose grid_slam_config() that is; all else has its defaults.
Config config_of(const GridSlamConfig& slam);

/// What is to be read of a log: config.log, with the LiDARs that the configuration places.
LogChoice log_choice(const Config& config);

/// Throws Error{config} naming the setting.
void validate(const Config& config);

/// Reads a YAML file over `base`, which has the defaults unless given; a file that chooses `sensor.model`
/// starts from that model's defaults, wherever the key stands. Throws Error{config} with file:line for an
/// unknown key (naming the nearest valid one), a duplicate key, a wrong type, or a value out of its range
/// (naming the range). `alpha1..alpha4` require `form` beside them. A file with `ros__parameters` of an amcl
/// node is nav2's, and translated (common/config/nav2_config.h).
Config read_config(const std::string& path, const Config& base = {});
/// The same from a text in memory; `name` stands for the file in messages.
Config config_from_text(const std::string& text, const std::string& name, const Config& base = {});

/// The whole configuration, every key with a comment that explains it. read_config gives it back.
std::string config_to_yaml(const Config& config);

}  // namespace parloc
