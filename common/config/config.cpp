// Reads a configuration: the groups of a YAML text (common/file/yaml_section.h) -> the table of settings.
#include "common/config/config.h"

#include <fmt/format.h>

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config_rules.h"
#include "common/config/config_text.h"
#include "common/error.h"
#include "common/file/yaml_section.h"

namespace parloc {
namespace {

/// A complete configuration has 5 KiB.
constexpr YamlRules kRules{"a configuration", 64 * 1024, ErrorKind::config};

/// Visits settings and gives those that the file has their value.
class SettingReader {
 public:
  /// `top` is the group that the settings' groups are looked up in, `section` the one to begin with.
  SettingReader(const YamlSection& top, const YamlSection& section) : top_(top), section_(section) {}

  template <class Number>
  void operator()(const Setting& setting, Number& target, const Limits<Number>& limits) {
    section_of(setting).number(setting.key, target, limits.low, limits.high, limits.above_low);
  }
  template <class Value, class Allowed>
  void operator()(const Setting& setting, std::optional<Value>& target, const Allowed& allowed) {
    Value value{};
    (*this)(setting, value, allowed);
    if (section_.has(setting.key)) target = value;
  }
  void operator()(const Setting& setting, bool& target) { section_of(setting).boolean(setting.key, target); }
  template <class Enum, std::size_t n>
  void operator()(const Setting& setting, Enum& target, const std::array<Choice<Enum>, n>& choices) {
    section_of(setting).choice(setting.key, target, choices);
  }

 private:
  /// The settings come group by group.
  const YamlSection& section_of(const Setting& setting) {
    if (section_.name() != setting.group) section_ = top_.section(setting.group);
    return section_;
  }

  const YamlSection& top_;
  YamlSection section_;
};

/// The alphas mean different things in the two forms, so a file that sets one must say which form it means.
void require_form(const YamlSection& top) {
  const YamlSection motion = top.section("motion");
  if (motion.has("form")) return;
  for (const char* alpha : {"alpha1", "alpha2", "alpha3", "alpha4"}) {
    if (motion.has(alpha)) {
      throw motion.error(alpha,
                         "needs motion.form beside it: seed (sigma linear in the motion) or thrun "
                         "(variance quadratic, as AMCL)");
    }
  }
}

/// The LiDAR of this name; made if it is the first time.
LidarConfig& lidar_of(const std::string& name, std::vector<LidarConfig>& lidars) {
  for (LidarConfig& lidar : lidars)
    if (lidar.name == name) return lidar;
  lidars.emplace_back().name = name;
  return lidars.back();
}

void read_lidars(const YamlSection& lidars, FilterConfig& config) {
  for (const std::string& name : lidars.keys()) {
    if (!config_text::is_lidar_name(name)) {
      throw lidars.error_at(lidars.line(name), fmt::format("lidars: '{}' is no name of a LiDAR: {}",
                                                           printable(name), config_text::kLidarNames));
    }
    const YamlSection section = lidars.section(name);
    if (section.keys().empty()) continue;  // it says nothing
    visit_lidar_settings(lidar_of(name, config.lidars), section.name().c_str(),
                         SettingReader(lidars, section));
  }
}

/// First of all: the model decides the other settings' defaults.
void read_model(const YamlSection& top, SensorConfig& sensor) {
  const YamlSection section = top.section("sensor");
  if (!section.has("model")) return;
  section.choice("model", sensor.model, kSensorModels);
  sensor = default_sensor(sensor.model);
}

}  // namespace

FilterConfig config_from_text(const std::string& text, const std::string& name, const FilterConfig& base) {
  const YamlSection top(text, name, kRules);
  FilterConfig config = base;
  read_model(top, config.sensor);
  visit_settings(config, SettingReader(top, top));
  read_lidars(top.section(kLidars.name), config);
  top.finish();
  require_form(top);
  if (const auto violation = first_violation(config))
    throw top.error_at(top.line(violation->name), violation->message);
  return config;
}

FilterConfig read_config(const std::string& path, const FilterConfig& base) {
  return config_from_text(read_yaml_file(path, kRules), path, base);
}

}  // namespace parloc
