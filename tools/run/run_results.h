// What a run is worth: errors against the truth, as JSON, as a report, and as lines for a person.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "common/eval/consistency.h"
#include "common/eval/metrics.h"
#include "common/map/grid_map.h"
#include "tools/report/report.h"
#include "tools/run/localize_log.h"

namespace parloc::tools {

/// A finished run with what it was run on.
struct RunResults {
  std::string map_path, log_path, truth_path, relations_path;  ///< The last two may be empty.
  std::string command_line;
  std::string init;  ///< As given; "truth" if the start came from there.
  Localization run;
  Trajectory truth;                            ///< Empty without one.
  std::optional<TrackErrors> errors;           ///< With a truth.
  std::optional<Consistency> consistency;      ///< With a truth.
  std::optional<TrackErrors> odometry_errors;  ///< Of dead reckoning, with a truth and a known start.
  std::optional<RelationErrors> relations;     ///< With relations.
  std::string mcap_path{};                     ///< Where it was recorded; empty: nowhere.
  std::size_t mcap_bytes = 0, mcap_messages = 0;
};

/// metrics.json: one object, fields in a fixed order; what needs a truth that is not there is null.
std::string metrics_json(const RunResults& results);

/// `map` must outlive the report.
RunReport run_report(const RunResults& results, const GridMap& map);

/// The lines that `parloc run` ends with, each ending in a newline.
std::string run_summary(const RunResults& results);

}  // namespace parloc::tools
