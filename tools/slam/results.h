// What `parloc slam` says of its work: JSON, a report, and lines for the terminal.
#pragma once

#include <optional>
#include <string>

#include "common/eval/metrics.h"
#include "tools/report/report.h"
#include "tools/slam/map_log.h"

namespace parloc::tools::slam {

struct SlamResults {
  std::string log_path, relations_path, truth_path, command_line;
  Mapping mapping;
  std::optional<RelationErrors> relations;
  std::optional<TrackErrors> errors;  ///< After alignment with the truth; nothing without one.
  Trajectory truth;                   ///< In the map's frame, as far as it could be laid on the trajectory.
};

/// Lays the truth on the trajectory and compares: a map has no other frame than its own.
void compare_with_truth(SlamResults& results, const Trajectory& truth);

std::string metrics_json(const SlamResults& results);
RunReport report_of(const SlamResults& results);
std::string summary_text(const SlamResults& results);

}  // namespace parloc::tools::slam
