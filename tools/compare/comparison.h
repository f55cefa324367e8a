// A comparison with its results, and the forms in which it is told.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/compare/published.h"
#include "tools/compare/run_all.h"
#include "tools/report/machine/machine.h"
#include "tools/report/machine/statistics.h"
#include "tools/report/text/table.h"

namespace parloc::tools::compare {

/// Over runs; both NaN without one, the deviation also of a single one.
struct MeanDeviation {
  double mean = 0.0, deviation = 0.0;  ///< Of the sample.
};
MeanDeviation mean_deviation(const std::vector<double>& values);

/// What the runs of one filter say together. Errors and NEES are those of the runs that kept their robot: how
/// far off a lost one ended says nothing about the filter.
struct Summary {
  std::size_t runs = 0, lost = 0;
  MeanDeviation position_rmse_m, position_mae_m, position_max_m;
  MeanDeviation heading_rmse_rad, heading_mae_rad, heading_max_rad;
  MeanDeviation nees;
  MeanDeviation lost_s;  ///< Of the lost runs: when, from the first scan.
  double away = 0.0;     ///< Share of all scans at which a run, lost or not, was farther off than kLost_m.
  double particles = 0.0;
  double skipped = 0.0;           ///< Share of the scans.
  TimeSummary step;               ///< Steps that took their scan in.
  double real_time_factor = 0.0;  ///< Seconds of driving per second in steps.
};
Summary summarise(const std::vector<FilterRun>& runs);

struct Comparison {
  std::string command, date;  ///< deciding_command(); UTC.
  Machine machine;
  std::string source, map_path;
  DrivePlan plan;
  Request request;
  const PublishedSetting* published = nullptr;  ///< If the setting is theirs.
  Outcome outcome;
  bool interrupted = false;
  double wall_s = 0.0;             ///< Of shards, all of theirs together.
  std::size_t shards = 0;          ///< That the runs come from; none if they were computed here.
  std::vector<Summary> summaries;  ///< By entry.
};

/// What was compared, and how: name and value.
Facts origin_facts(const Comparison& c);
Facts machine_facts(const Comparison& c);

/// One row per filter. The second holds what a clock has measured.
Table error_table(const Comparison& c);
Table time_table(const Comparison& c);

std::string terminal_text(const Comparison& c);
std::string markdown_text(const Comparison& c);
/// Everything that is measured on a clock is in "times".
std::string json_text(const Comparison& c);
std::string html_page(const Comparison& c);

}  // namespace parloc::tools::compare
