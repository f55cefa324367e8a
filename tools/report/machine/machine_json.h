// What the JSON files of several commands have in common.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/report/machine/machine.h"

namespace parloc::tools {

nlohmann::ordered_json build_json();
nlohmann::ordered_json machine_json(const Machine& machine);

/// null instead of an empty text.
nlohmann::ordered_json text_or_null(const std::string& text);

/// For a file; bytes that are no UTF-8, which the name of a file on the command line may have, are replaced.
std::string file_text(const nlohmann::ordered_json& json);

}  // namespace parloc::tools
