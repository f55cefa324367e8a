// What the results of several commands have in common.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/eval/metrics.h"
#include "tools/report/report.h"

namespace parloc::tools {

/// An object with one object per group.
nlohmann::ordered_json config_json(const Config& config);
/// The same for people: "group.key" and value.
FactTable config_facts(const Config& config);

/// null without relations; values are null where no relation could be compared.
nlohmann::ordered_json relations_json(const std::optional<RelationErrors>& errors);
std::string relations_text(const RelationErrors& errors);

}  // namespace parloc::tools
