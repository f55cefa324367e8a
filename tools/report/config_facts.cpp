#include "tools/report/config_facts.h"

#include <fmt/format.h>

#include <numbers>
#include <utility>
#include <vector>

#include "common/config/config_settings.h"

namespace parloc::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180.0 / std::numbers::pi;

void put(Json& json, const Setting& setting) {
  if (const auto text = value_text(setting)) {
    const bool is_text = std::holds_alternative<ChoiceSetting>(setting.value);
    json[setting.key] = is_text ? Json(*text) : Json::parse(*text);
  }
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

Json relations_json(const std::optional<RelationErrors>& errors) {
  if (!errors) return nullptr;
  const bool known = errors->compared > 0;
  const auto value = [&](double v) { return known ? Json(v) : Json(nullptr); };
  return {{"compared", errors->compared},
          {"without_pose", errors->without_pose},
          {"translation_mean_m", value(errors->translation_mean_m)},
          {"translation_std_m", value(errors->translation_std_m)},
          {"translation_rmse_m", value(errors->translation_rmse_m)},
          {"translation_median_m", value(errors->translation_median_m)},
          {"translation_max_m", value(errors->translation_max_m)},
          {"rotation_mean_rad", value(errors->rotation_mean_rad)},
          {"rotation_std_rad", value(errors->rotation_std_rad)},
          {"rotation_rmse_rad", value(errors->rotation_rmse_rad)},
          {"rotation_median_rad", value(errors->rotation_median_rad)},
          {"rotation_max_rad", value(errors->rotation_max_rad)}};
}

std::string relations_text(const RelationErrors& e) {
  return fmt::format("{:.3f} +- {:.3f} m, {:.2f} +- {:.2f} degrees, from {}", e.translation_mean_m,
                     e.translation_std_m, e.rotation_mean_rad * kDegrees, e.rotation_std_rad * kDegrees,
                     e.compared);
}

}  // namespace parloc::tools
