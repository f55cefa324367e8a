// What `parloc slam` says of its work: JSON, a report, and lines for the terminal.
#pragma once

#include <optional>
#include <string>

#include "common/eval/metrics.h"
#include "common/io/report.h"
#include "tools/slam/map_log.h"

namespace parloc::slam {

struct SlamResults {
  std::string log_path, relations_path, command_line;
  Mapping mapping;
  std::optional<RelationErrors> relations;
};

std::string metrics_json(const SlamResults& results);
RunReport report_of(const SlamResults& results);
std::string summary_text(const SlamResults& results);

}  // namespace parloc::slam
