#include "tools/evaluate/relations.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/error.h"
#include "tools/evaluate/relations_tables.h"
#include "tools/report/config_facts.h"
#include "tools/report/machine/machine_json.h"
#include "tools/report/relation_facts.h"

namespace parloc::tools::evaluate {
namespace {

using Json = nlohmann::ordered_json;

Json published_json(const RelationsReport& r) {
  Json figures = Json::array();
  for (const PublishedLog* log : published_beside(r))
    for (std::size_t m = 0; m < kPublishedMethods.size(); ++m)
      figures.push_back({{"dataset", log->name},
                         {"method", kPublishedMethods[m]},
                         {"translation_mean_m", log->errors[m].mean_m},
                         {"translation_std_m", log->errors[m].std_m}});
  return {{"source", kPublishedSource}, {"figures", figures}};
}

Json largest_json(const RelationsReport& r) {
  Json largest = Json::array();
  for (const RelationError& e : largest_errors(r.errors))
    largest.push_back({{"stamp_1_s", e.stamp_1_s},
                       {"stamp_2_s", e.stamp_2_s},
                       {"translation_m", e.translation_m},
                       {"rotation_rad", e.rotation_rad}});
  return largest;
}

}  // namespace

const PublishedLog& published_log(const std::string& name) {
  std::string names;
  for (const PublishedLog& log : kPublishedLogs) {
    if (name == log.name) return log;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", log.name);
  }
  throw Error(ErrorKind::usage, fmt::format("--dataset: expected one of {}, got '{}'", names, name));
}

RelationsReport judge_by_relations(const std::string& trajectory_path, const std::string& relations_path) {
  RelationsReport r;
  r.trajectory_path = trajectory_path;
  r.relations_path = relations_path;
  r.trajectory = read_tum(trajectory_path);
  r.errors = compare_relations(r.trajectory, read_relations(relations_path));
  if (r.errors.compared == 0)
    throw input_error(relations_path, 0,
                      fmt::format("expected relations between poses of {}: of {}, none has both its stamps "
                                  "there, equal to 6 decimals",
                                  trajectory_path, r.errors.without_pose));
  return r;
}

std::string terminal_text(const RelationsReport& r) {
  std::string text;
  text += aligned_text(origin_facts(r), 18);
  constexpr std::size_t kWidth = 100;
  return text + "\n" + terminal_text(error_table(r), kWidth) + "\n" +
         terminal_text(published_table(r), kWidth);
}

std::string json_text(const RelationsReport& r) {
  Json json{{"tool", "parloc evaluate"}, {"command", r.command}};
  json["build"] = build_json();
  json["trajectory"] = {{"file", r.trajectory_path},
                        {"poses", r.trajectory.size()},
                        {"repeated_stamps", r.errors.repeated_stamps}};
  json["relations_file"] = r.relations_path;
  json["relations"] = tools::relations_json(r.errors);
  json["dataset"] = r.log == nullptr ? Json(nullptr) : Json(r.log->name);
  json["published"] = published_json(r);
  json["largest"] = largest_json(r);
  return file_text(json);
}

}  // namespace parloc::tools::evaluate
