// How far off the relations between a trajectory's poses are, for results.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/eval/metrics.h"

namespace parloc::tools {

/// null without relations; values are null where no relation could be compared.
nlohmann::ordered_json relations_json(const std::optional<RelationErrors>& errors);
std::string relations_text(const RelationErrors& errors);

}  // namespace parloc::tools
