// Prints a configuration as YAML with a comment per key.
#include <fmt/format.h>

#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/config/config_text.h"

namespace parloc {
namespace {

/// Appends one line per setting: "  key: value   # what it means (limits)".
struct Printer {
  std::string text;
  std::string group;
  const char* indent = "";

  template <class Number>
  void operator()(const Setting& setting, Number value, const Limits<Number>& limits) {
    // fmt's {} is the shortest text that reads back as the same number.
    line(setting, fmt::format("{}", value), config_text::limits_text(limits));
  }
  template <class Value, class Allowed>
  void operator()(const Setting& setting, const std::optional<Value>& value, const Allowed& allowed) {
    if (value) (*this)(setting, *value, allowed);
  }
  void operator()(const Setting& setting, bool value) {
    line(setting, value ? "true" : "false", "true or false");
  }
  template <class Enum, std::size_t n>
  void operator()(const Setting& setting, Enum value, const std::array<Choice<Enum>, n>& choices) {
    const char* name = config_text::choice_name(value, choices);
    line(setting, name ? name : "?", config_text::choices_text(choices));
  }

 private:
  void line(const Setting& setting, const std::string& value, const std::string& allowed) {
    if (group != setting.group) open_group(setting.group);
    const std::string entry = fmt::format("{}{}: {}", indent, setting.key, value);
    text += fmt::format("{:<36}  # {} ({})\n", entry, setting.doc, allowed);
  }
  void open_group(const char* name) {
    group = name;
    for (const SettingGroup& known : kSettingGroups) {
      if (group == known.name) text += fmt::format("\n# {}\n", known.doc);
    }
    text += group + ":\n";
    indent = "  ";
  }
};

/// The LiDARs' entries; without any, one that is commented out and says what it may hold.
std::string lidars_to_yaml(const std::vector<LidarConfig>& lidars) {
  Printer printer;
  if (lidars.empty()) {
    LidarConfig every{"front", 0.0,           0.0, 0.0, false, 0.1, 40.0, 100, ZeroPolicy::invalid,
                      0.0,     StampAt::first};
    printer.indent = "#     ";
    visit_lidar_settings(every, "", printer);
    return fmt::format("\n# {}\n# {}:\n#   {}:\n{}", kLidars.doc, kLidars.name, every.name, printer.text);
  }
  printer.indent = "    ";
  for (const LidarConfig& lidar : lidars) {
    printer.text += fmt::format("  {}:\n", lidar.name);
    visit_lidar_settings(lidar, "", printer);
  }
  return fmt::format("\n# {}\n{}:\n{}", kLidars.doc, kLidars.name, printer.text);
}

}  // namespace

std::string config_to_yaml(const FilterConfig& config) {
  Printer printer;
  visit_settings(config, printer);
  return printer.text + lidars_to_yaml(config.lidars);
}

}  // namespace parloc
