// What the results of several commands have in common, as JSON and for people.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

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

/// "12.3 s in 2 jobs", or of shards all together.
std::string work_text(double wall_s, int jobs, std::size_t shards);

Json build_json();
Json machine_json(const Machine& machine);

/// null instead of an empty text.
Json text_or_null(const std::string& text);

/// For a file; bytes that are no UTF-8, which the name of a file on the command line may have, are replaced.
std::string file_text(const Json& json);

/// Takes a part of a file.
using TextSink = std::function<void(std::string_view)>;
using RowSink = std::function<void(const Json& row)>;
/// What file_text() gives of `json` with one field more at its end, whose rows are told one by one: they need
/// not be in memory together.
void write_json(const Json& json, const char* rows_name, const std::function<void(const RowSink&)>& rows,
                const TextSink& sink);
/// A TextSink: standard output.
void print_text(std::string_view text);
/// Into a file, which is there as a whole or not at all. Throws Error{output}.
void write_file(const std::string& path, const std::function<void(const TextSink&)>& write);

/// An object with one object per group.
Json config_json(const Config& config);
/// The same for people: "group.key" and value.
FactTable config_facts(const Config& config);

/// null without relations; values are null where no relation could be compared.
Json relations_json(const std::optional<RelationErrors>& errors);
std::string relations_text(const RelationErrors& errors);

}  // namespace parloc::tools
