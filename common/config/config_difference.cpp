#include <fmt/format.h>

#include <map>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/config/config_text.h"

namespace parloc {
namespace {

/// Settings by full name, as text.
struct Leaves {
  std::map<std::string, std::string> text;
  std::string prefix;

  template <class Number>
  void operator()(const Setting& setting, Number value, const Limits<Number>&) {
    place(setting) = fmt::format("{}", value);
  }
  template <class Value, class Allowed>
  void operator()(const Setting& setting, const std::optional<Value>& value, const Allowed& allowed) {
    if (value) (*this)(setting, *value, allowed);
  }
  void operator()(const Setting& setting, bool value) { place(setting) = value ? "true" : "false"; }
  template <class Enum, std::size_t n>
  void operator()(const Setting& setting, Enum value, const std::array<Choice<Enum>, n>& choices) {
    const char* name = config_text::choice_name(value, choices);
    place(setting) = name != nullptr ? name : "?";
  }
  std::string& place(const Setting& setting) { return text[prefix + config_text::full_name(setting)]; }
};

std::map<std::string, std::string> leaves_of(const FilterConfig& config) {
  Leaves leaves;
  visit_settings(config, leaves);
  for (const LidarConfig& lidar : config.lidars) {
    leaves.prefix = fmt::format("{}.{}.", kLidars.name, lidar.name);
    visit_lidar_settings(lidar, "", leaves);
  }
  for (const char* where : {"backend", "threads", "device"}) leaves.text.erase(where);
  return leaves.text;
}

}  // namespace

std::string config_difference(const FilterConfig& there, const FilterConfig& here) {
  std::map<std::string, std::string> old_text = leaves_of(there), new_text = leaves_of(here);
  for (const auto& leaf : new_text) old_text.try_emplace(leaf.first, "not set");
  for (const auto& [key, value] : old_text) {
    const std::string& now = new_text.try_emplace(key, "not set").first->second;
    if (value != now) return fmt::format("{} is {} there and {} here", key, value, now);
  }
  return "";
}

}  // namespace parloc
