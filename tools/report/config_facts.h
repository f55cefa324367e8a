// The configuration, for results.
#pragma once

#include <nlohmann/json.hpp>

#include "common/config/config.h"
#include "tools/report/text/facts.h"

namespace parloc::tools {

/// An object with one object per group.
nlohmann::ordered_json config_json(const Config& config);
/// The same for people: "group.key" and value.
FactTable config_facts(const Config& config);

}  // namespace parloc::tools
