#include "tools/report/config_facts.h"

#include <utility>
#include <vector>

#include "common/config/settings_table.h"

namespace parloc::tools {
namespace {

using Json = nlohmann::ordered_json;

/// The configuration as a JSON object with one object per group.
struct ConfigJson {
  Json json = Json::object();

  template <class Number>
  void operator()(const Setting& setting, Number value, const Limits<Number>&) {
    place(setting) = value;
  }
  void operator()(const Setting& setting, bool value) { place(setting) = value; }
  template <class Value, class Allowed>
  void operator()(const Setting& setting, const std::optional<Value>& value, const Allowed& allowed) {
    if (value) (*this)(setting, *value, allowed);
  }
  template <class Enum, std::size_t n>
  void operator()(const Setting& setting, Enum value, const std::array<Choice<Enum>, n>& choices) {
    for (const auto& choice : choices) {
      if (choice.value == value) place(setting) = choice.name;
    }
  }
  Json& place(const Setting& setting) {
    return *setting.group == '\0' ? json[setting.key] : json[setting.group][setting.key];
  }
};

/// "group.key" and value for every leaf.
void add_leaves(const std::string& prefix, const Json& json, std::vector<Fact>& facts) {
  for (const auto& [key, value] : json.items()) {
    const std::string name = prefix.empty() ? key : prefix + "." + key;
    if (value.is_object()) {
      add_leaves(name, value, facts);
    } else {
      facts.push_back({name, value.is_string() ? value.get<std::string>() : value.dump()});
    }
  }
}

}  // namespace

Json config_json(const FilterConfig& config) {
  ConfigJson visitor;
  visit_settings(config, visitor);
  for (const LidarConfig& lidar : config.lidars) {
    ConfigJson entry;
    visit_lidar_settings(lidar, "", entry);
    visitor.json[kLidars.name][lidar.name] = std::move(entry.json);
  }
  return std::move(visitor.json);
}

FactTable config_facts(const FilterConfig& config) {
  FactTable table{"Configuration", {}};
  add_leaves("", config_json(config), table.facts);
  return table;
}

}  // namespace parloc::tools
