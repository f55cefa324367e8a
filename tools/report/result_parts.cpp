#include "tools/report/result_parts.h"

#include <fmt/format.h>

#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "common/config/config_settings.h"
#include "common/file/output_file.h"
#include "tools/report/machine/machine.h"

namespace parloc::tools {
namespace {

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
  void operator()(const TextSetting& text) const {
    if (!text.text->empty()) json[key] = *text.text;
  }
  void operator()(const IntervalsSetting& list) const {
    for (const auto& [from, to] : list.get()) json[key].push_back({from, to});
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

Json text_or_null(const std::string& text) {
  return json_if(!text.empty(), text);
}

std::string work_text(double wall_s, int jobs, std::size_t shards) {
  if (shards > 0)
    return fmt::format("{:.1f} s in {} shard{} together", wall_s, shards, shards == 1 ? "" : "s");
  return fmt::format("{:.1f} s in {} job{}", wall_s, jobs, jobs == 1 ? "" : "s");
}

Json build_json() {
  return {{"version", kVersion}, {"commit", text_or_null(kCommit)}, {"compiler", kCompiler},
          {"flags", kFlags},     {"build_type", kBuildType},        {"cuda", kCuda}};
}

Json machine_json(const Machine& m) {
  return {{"cpu", m.cpu},
          {"cores", m.cores},
          {"memory_bytes", m.memory_bytes},
          {"os", m.os},
          {"load_average", json_if(m.load_average >= 0.0, m.load_average)},
          {"gpu_driver", text_or_null(m.gpu_driver)},
          {"devices", m.devices},
          {"settings", m.settings}};
}

std::string file_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_json(const Json& json, const char* rows_name, const std::function<void(const RowSink&)>& rows,
                const TextSink& sink) {
  Json head = json;
  head[rows_name] = Json::array();
  std::string text = file_text(head);
  constexpr std::string_view kEnd = "]\n}\n";
  text.resize(text.size() - kEnd.size());
  sink(text);
  bool first = true;
  rows([&](const Json& row) {
    sink(first ? "\n" : ",\n");
    first = false;
    std::string lines = "    ";
    std::string of_row = file_text(row);
    of_row.pop_back();
    for (const char c : of_row) {
      lines += c;
      if (c == '\n') lines += "    ";
    }
    sink(lines);
  });
  sink(first ? "" : "\n  ");
  sink(kEnd);
}

void print_text(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void write_file(const std::string& path, const std::function<void(const TextSink&)>& write) {
  FileReplacement file(path);
  write([&](std::string_view text) { file.write(text.data(), text.size()); });
  file.commit();
}

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
  const auto value = [&](double v) { return json_if(known, v); };
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
                     e.translation_std_m, e.rotation_mean_rad * (180.0 / std::numbers::pi),
                     e.rotation_std_rad * (180.0 / std::numbers::pi), e.compared);
}

}  // namespace parloc::tools
