// What the results of several commands have in common, as JSON and for people.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/eval/metrics.h"
#include "tools/report/machine/machine.h"
#include "tools/report/text/table.h"

namespace parloc::tools {

using Json = nlohmann::ordered_json;  // fields in the order in which they are set; a NaN is null

/// The value, or null.
template <class Value>
Json json_if(bool known, const Value& value) {
  return known ? Json(value) : Json(nullptr);
}
template <class Value>
Json json_of(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json build_json();
Json machine_json(const Machine& machine);

/// null instead of an empty text.
Json text_or_null(const std::string& text);

/// For a file; bytes that are no UTF-8, which the name of a file on the command line may have, are replaced.
std::string file_text(const Json& json);

/// An object with one object per group.
Json config_json(const Config& config);
/// The same for people: "group.key" and value.
FactTable config_facts(const Config& config);

/// null without relations; values are null where no relation could be compared.
Json relations_json(const std::optional<RelationErrors>& errors);
std::string relations_text(const RelationErrors& errors);

}  // namespace parloc::tools
