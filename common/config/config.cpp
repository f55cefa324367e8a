#include "common/config/config.h"

#include <optional>

#include "common/config/config_settings.h"
#include "common/error.h"
#include "common/filter/filter_settings.h"
#include "common/flow/flow_settings.h"
#include "common/localize/localize_settings.h"
#include "common/search/search_settings.h"
#include "common/settings/read_settings.h"
#include "common/slam/slam_settings.h"

namespace parloc {
namespace {

void add_settings(Settings& s, LogChoice& log) {
  s.group("log", "What is read of a bag that has more than one of a kind");
  s.add("scan_topic", "Scans or clouds of points; several LiDARs with commas between", log.scan_topic);
  s.add("odometry_topic", "Of type nav_msgs/Odometry", log.odometry_topic);
  s.add("odometry_frame", "Its transforms in /tf are the odometry", log.odometry_frame);
  s.add("base_frame", "The robot's, whose pose is estimated", log.base_frame);
  s.add("map_topic", "Of type nav_msgs/OccupancyGrid", log.map_topic);
  s.add("truth_topic", "True poses, of the base", log.truth_topic);
  s.add("truth_frame", "True poses are where /tf says that the base is in this frame", log.truth_frame);
  s.add("cloud_low", "Points of a cloud above this height over the base are a scan [m]", log.cloud_low,
        {-10.0, 100.0});
  s.add("cloud_high", "... and below this [m]", log.cloud_high, {-10.0, 100.0});
}

/// A complete configuration has 8 KiB.
constexpr YamlRules kRules{"a configuration", 64 * 1024, ErrorKind::config};

/// The alphas mean different things in each form, so a file that sets one must say which form it means.
void require_form(const YamlSection& top) {
  const YamlSection motion = top.section("motion");
  if (motion.has("form")) return;
  for (const char* alpha : {"alpha1", "alpha2", "alpha3", "alpha4", "alpha5"})
    if (motion.has(alpha))
      throw motion.error(alpha,
                         "needs motion.form beside it: seed (sigma linear in the motion), thrun "
                         "(variance quadratic, as AMCL) or omni (likewise, and sideways)");
}

}  // namespace

std::optional<Violation> first_violation(const Config& config) {
  Config copy = config;
  if (auto violation = first_beyond_limits(settings_of(copy))) return violation;
  return broken_rule(config);
}

FlowFilterConfig flow_filter_config(const Config& config) {
  FlowFilterConfig c;
  static_cast<StepConfig&>(c) = config;
  c.scan.max_beams = config.flow_max_beams;
  c.update_min_d = c.update_min_a = 0.0;
  c.particles = config.most_particles();
  c.resample = config.resample;
  c.flow = config.flow;
  return c;
}

GridSlamConfig grid_slam_config(const Config& config) {
  GridSlamConfig c;
  static_cast<StepConfig&>(c) = config;
  c.scan.max_beams = config.slam_max_beams;
  c.update_min_d = config.slam_update_min_d;
  c.update_min_a = config.slam_update_min_a;
  c.slam = config.slam;
  return c;
}

Config config_of(const GridSlamConfig& slam) {
  Config c;
  static_cast<StepConfig&>(c) = slam;
  c.scan.max_beams = Config().scan.max_beams;
  c.update_min_d = c.update_min_a = 0.0;
  c.slam_max_beams = slam.scan.max_beams;
  c.slam_update_min_d = slam.update_min_d;
  c.slam_update_min_a = slam.update_min_a;
  c.slam = slam.slam;
  return c;
}

Settings settings_of(Config& config) {
  Settings s;
  add_settings(s, static_cast<FilterConfig&>(config));
  add_settings(s, config.localize);
  add_flow_settings(s, config.flow, config.flow_max_beams);
  add_slam_settings(s, config.slam, config.slam_max_beams, config.slam_update_min_d,
                    config.slam_update_min_a);
  add_settings(s, config.search);
  add_settings(s, config.log);
  return s;
}

LogChoice log_choice(const Config& config) {
  LogChoice choice = config.log;
  for (const LidarConfig& lidar : config.lidars)
    if (lidar.x && lidar.y && lidar.yaw) choice.mounted.push_back(lidar.name);
  choice.without_odometry = config.slam.odometry == SlamOdometry::scans;
  return choice;
}

void validate(const Config& config) {
  require_none(first_violation(config));
}

Config parloc_config_from_text(const std::string& text, const std::string& name, const Config& base) {
  const YamlSection top(text, name, kRules);
  Config config = base;
  const Settings settings = settings_of(config);
  if (top.section("sensor").has("model")) {  // first: it decides other defaults
    read_setting(top, settings, "sensor.model");
    config.sensor = default_sensor(config.sensor.model);
  }
  read_settings(top, settings);
  top.finish();
  require_form(top);
  require_none(top, first_violation(config));
  return config;
}

std::string config_to_yaml(const Config& config) {
  Config copy = config;
  return settings_to_yaml(settings_of(copy));
}

}  // namespace parloc
