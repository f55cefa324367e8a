#include "common/simulator/scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "common/file/yaml_section.h"
#include "common/math/angle_units.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kFarthest_m = 100'000.0;
constexpr double kLongestRange_m = 1000.0;
constexpr std::size_t kLongestFile = 1024 * 1024;
constexpr YamlRules kScenarioRules{"a scenario", kLongestFile, ErrorKind::config};
constexpr YamlRules kPathRules{"a path", kLongestFile, ErrorKind::config};

void read_degrees(const YamlSection& section, const char* key, double& target_rad, double low_deg,
                  double high_deg) {
  double degrees = 0.0;
  if (!section.has(key)) return;
  section.number(key, degrees, low_deg, high_deg);
  target_rad = degrees * kRadPerDeg;
}

void read_pose(const YamlSection& section, const char* key, Pose& target) {
  double values[3];
  if (!section.has(key)) return;
  section.numbers(key, values, 3, -kFarthest_m, kFarthest_m, "[x, y, heading in degrees]");
  target = {values[0], values[1], wrap64(values[2] * kRadPerDeg)};
}

void read_lidar(const YamlSection& section, SimulatedLidar& lidar) {
  section.number("beams", lidar.beams, 1, 4096);
  read_degrees(section, "angle_min_deg", lidar.angle_min_rad, -360.0, 360.0);
  read_degrees(section, "angle_step_deg", lidar.angle_step_rad, -360.0, 360.0);
  section.number("range_min", lidar.range_min_m, 0.0, kLongestRange_m);
  section.number("range_max", lidar.range_max_m, 0.01, kLongestRange_m);
  section.number("sigma_range", lidar.sigma_range_m, 0.0, 10.0);
  section.number("sigma_range_relative", lidar.sigma_range_relative, 0.0, 1.0);
  section.number("dropout_probability", lidar.dropout_probability, 0.0, 1.0);
  section.choice("dropout_value", lidar.dropout_value,
                 {{"zero", DropoutValue::zero}, {"nan", DropoutValue::nan}, {"inf", DropoutValue::inf}});
  section.choice("over_range", lidar.over_range,
                 {{"max", OverRange::max}, {"inf", OverRange::inf}, {"code", OverRange::code}});
  section.number("over_range_code", lidar.over_range_code_m, 0.0, kFarthest_m);
  read_pose(section, "mount", lidar.T_base_sensor);
  section.boolean("upside_down", lidar.upside_down);
  section.number("scan_time", lidar.scan_time_s, 0.0, 1.0);
  section.choice("stamp_at", lidar.stamp_at,
                 {{"first", StampAt::first}, {"middle", StampAt::middle}, {"last", StampAt::last}});
  section.number("delay", lidar.delay_s, 0.0, 3600.0);
  if (lidar.range_min_m >= lidar.range_max_m) throw section.error("range_min", "must be below range_max");
}

/// Either `lidar`, or `lidars`: a list of such groups.
void read_lidars(const YamlSection& top, Scenario& scenario) {
  if (!top.has("lidars")) return read_lidar(top.section("lidar"), scenario.lidar);
  if (top.has("lidar")) throw top.error("lidars", "and lidar: only one of the two may be there");
  constexpr std::size_t most = 9;  // robotlaser1 to robotlaser9
  const std::vector<YamlSection> sections = top.sections("lidars");
  if (sections.empty() || sections.size() > most)
    throw top.error("lidars", fmt::format("must be a list of 1 to {} LiDARs", most));
  scenario.more_lidars.resize(sections.size() - 1);
  for (std::size_t k = 0; k < sections.size(); ++k)
    read_lidar(sections[k], k == 0 ? scenario.lidar : scenario.more_lidars[k - 1]);
}

void read_odometry(const YamlSection& section, SimulatedOdometry& odometry) {
  enum class Form { seed, thrun, wheels };
  Form form = Form::seed;
  section.number("rate", odometry.rate_hz, 0.01, 200.0);
  const bool has_form = section.has("form");
  section.choice("form", form, {{"seed", Form::seed}, {"thrun", Form::thrun}, {"wheels", Form::wheels}});
  odometry.noise.form = form == Form::thrun ? MotionForm::thrun : MotionForm::seed;
  const bool wheels = form == Form::wheels;
  odometry.errors = wheels ? OdometryErrors::wheels : OdometryErrors::motion_model;
  section.number("kappa", odometry.kappa_m, 0.0, 1.0);
  section.number("wheel_base", odometry.wheel_base_m, 0.01, 100.0);
  for (const char* key : {"kappa", "wheel_base"})
    if (section.has(key) && !wheels) throw section.error(key, "needs form: wheels beside it");
  const std::pair<const char*, double*> alphas[] = {{"alpha1", &odometry.noise.alpha1},
                                                    {"alpha2", &odometry.noise.alpha2},
                                                    {"alpha3", &odometry.noise.alpha3},
                                                    {"alpha4", &odometry.noise.alpha4}};
  for (const auto& [key, target] : alphas) {
    section.number(key, *target, 0.0, 100.0);
    if (section.has(key) && wheels)
      throw section.error(key, "has no meaning for form: wheels, which has kappa and wheel_base");
    if (section.has(key) && !has_form) {
      throw section.error(
          key, "needs form beside it: seed (sigma linear in the motion) or thrun (variance quadratic)");
    }
  }
  section.number("scale_translation", odometry.scale_translation, 0.1, 10.0);
  section.number("scale_rotation", odometry.scale_rotation, 0.1, 10.0);
  double drift_deg_per_m = 0.0;
  section.number("drift_deg_per_m", drift_deg_per_m, -360.0, 360.0);
  odometry.drift_rad_per_m = drift_deg_per_m * kRadPerDeg;
  section.number("delay", odometry.delay_s, 0.0, 10.0);
  read_pose(section, "start", odometry.start);
}

void read_clutter(const YamlSection& section, SimulatedClutter& clutter) {
  section.number("boxes", clutter.boxes, 0, 10'000);
  section.number("box_min", clutter.box_min_m, 0.01, 100.0);
  section.number("box_max", clutter.box_max_m, 0.01, 100.0);
  section.number("box_reach", clutter.box_reach_m, 0.1, 1000.0);
  section.number("clearance", clutter.clearance_m, 0.0, 100.0);
  section.number("people", clutter.people, 0, 1000);
  section.number("person_radius", clutter.person_radius_m, 0.01, 10.0);
  section.number("person_min", clutter.person_min_m, 0.05, 1000.0);
  section.number("person_max", clutter.person_max_m, 0.05, 1000.0);
  if (clutter.box_min_m > clutter.box_max_m) throw section.error("box_min", "must not exceed box_max");
  if (clutter.person_min_m > clutter.person_max_m)
    throw section.error("person_min", "must not exceed person_max");
}

Waypoint read_point(const YamlSection& top, const YamlNode& node, std::size_t number) {
  const std::string what = fmt::format("points: point {}", number);
  const std::size_t size = node.kind == YamlKind::list ? node.items.size() : 0;
  if (size < 2 || size > 4)
    throw top.error_at(node.line, what + " must be [x, y], [x, y, pause_s] or [x, y, pause_s, spin_deg]");
  const auto value = [&](std::size_t k, const char* name, double low, double high) {
    return k < size ? top.number_in(node.items[k], fmt::format("{}, {}", what, name), low, high) : 0.0;
  };
  return {value(0, "x", -kFarthest_m, kFarthest_m), value(1, "y", -kFarthest_m, kFarthest_m),
          value(2, "pause_s", 0.0, 3600.0), value(3, "spin_deg", -36000.0, 36000.0) * kRadPerDeg};
}

/// "$NAME/rest" with the folder that the environment calls NAME; anything else as it is.
std::string with_environment(const std::string& file, const std::string& path) {
  if (path.empty() || path[0] != '$') return path;
  const std::size_t end = std::min(path.find('/'), path.size());
  const std::string name = path.substr(1, end - 1);
  const char* folder = std::getenv(name.c_str());
  if (folder == nullptr || *folder == '\0')
    throw Error(ErrorKind::config,
                fmt::format("{}: {}: expected the environment variable {} to name a folder, it is not set",
                            file, path, name));
  return std::filesystem::absolute(folder).string() + path.substr(end);
}

std::string beside(const std::string& file, const std::string& named) {
  const std::filesystem::path path(with_environment(file, named));
  return (path.is_absolute() ? path : std::filesystem::path(file).parent_path() / path)
      .lexically_normal()
      .string();
}

}  // namespace

WaypointPath waypoints_from_text(const std::string& text, const std::string& name) {
  const YamlSection top(text, name, kPathRules);
  WaypointPath path;
  path.name = name;
  top.number("speed", path.speed_mps, 0.001, 100.0);
  top.number("turn_rate", path.turn_rate_rad_s, 0.001, 100.0);
  top.require("points");
  const std::vector<YamlNode>& points = top.list("points", "a list of at least two points", 2);
  top.finish();
  for (const YamlNode& node : points) {
    const std::size_t number = path.points.size() + 1;
    const Waypoint point = read_point(top, node, number);
    if (number > 1 && path.points.back().x_m == point.x_m && path.points.back().y_m == point.y_m)
      throw top.error_at(node.line, fmt::format("points: point {} is the same as the one before", number));
    path.points.push_back(point);
  }
  return path;
}

WaypointPath read_waypoints(const std::string& yaml_path) {
  return waypoints_from_text(read_yaml_file(yaml_path, kPathRules), yaml_path);
}

Scenario scenario_from_text(const std::string& text, const std::string& name) {
  const YamlSection top(text, name, kScenarioRules);
  Scenario scenario;
  top.require("map");
  top.text("map", scenario.map_path);
  top.text("localization_map", scenario.localization_map_path);
  top.require("path");
  top.text("path", scenario.path_file);
  top.number("seed", scenario.seed, 0, std::numeric_limits<std::uint64_t>::max());
  top.number("scan_rate", scenario.scan_rate_hz, 0.01, 200.0);
  read_lidars(top, scenario);
  read_odometry(top.section("odometry"), scenario.odometry);
  read_clutter(top.section("clutter"), scenario.clutter);
  top.finish();
  scenario.map_path = beside(name, scenario.map_path);
  if (!scenario.localization_map_path.empty()) {
    scenario.localization_map_path = beside(name, scenario.localization_map_path);
  }
  scenario.path_file = beside(name, scenario.path_file);
  return scenario;
}

Scenario read_scenario(const std::string& yaml_path) {
  Scenario scenario = scenario_from_text(read_yaml_file(yaml_path, kScenarioRules), yaml_path);
  scenario.path = read_waypoints(scenario.path_file);
  return scenario;
}

}  // namespace parloc
