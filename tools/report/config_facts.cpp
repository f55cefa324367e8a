#include "tools/report/config_facts.h"

#include <utility>
#include <vector>

#include "common/config/config_settings.h"

namespace parloc::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Sets `json` to a value, unless it is missing.
struct Put {
  Json& json;
  const std::string& key;

  template <class Number>
  void operator()(const NumberSetting<Number>& number) const {
    (*this)(number.slot);
  }
  template <class Value>
  void operator()(const Slot<Value>& slot) const {
    if (const Value* value = slot.get()) json[key] = *value;
  }
  void operator()(const ChoiceSetting& choice) const {
    if (const char* name = choice.name()) json[key] = name;
  }
};

void put(Json& json, const Setting& setting) {
  std::visit(Put{json, setting.key}, setting.value);
}

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

Json config_json(const Config& config) {
  Config copy = config;
  const Settings settings = settings_of(copy);
  Json json = Json::object();
  for (const Setting& setting : settings.all)
    put(setting.group.empty() ? json : json[setting.group], setting);
  for (const std::string& name : settings.named->names())
    for (const Setting& setting : settings.named->of(name))
      put(json[settings.named->group.name][name], setting);
  return json;
}

FactTable config_facts(const Config& config) {
  FactTable table{"Configuration", {}};
  add_leaves("", config_json(config), table.facts);
  return table;
}

}  // namespace parloc::tools
