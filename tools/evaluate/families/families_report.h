// Families of drives with both their runs, and the forms in which they are told.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/eval/families/drive_score.h"
#include "common/eval/families/family_summary.h"
#include "common/eval/result_stream.h"
#include "tools/report/machine/machine.h"
#include "tools/report/result_parts.h"
#include "tools/report/text/table.h"

namespace parloc::tools::families {

struct FamiliesReport {
  std::string command, date;  ///< deciding_command(); UTC.
  Machine machine;
  std::string source;  ///< Where the drives come from, for people.
  std::uint64_t first_seed = 1;
  std::size_t wanted = 0;  ///< Drives, of all families together.
  int jobs = 1;
  std::size_t shards = 0;    ///< That the drives come from; none if they were computed here.
  Config config;             ///< Of the closed loop; the bare filter has the same, but does not recover.
  bool interrupted = false;  ///< Fewer drives than wanted.
  double wall_s = 0.0;       ///< Of shards, all of theirs together.
  ResultStream<DriveResult> drives;
  std::vector<FamilySummary> families;
  FamilySummary all;
};

std::string terminal_text(const FamiliesReport& report);
/// Everything that is measured on a clock is in "times".
void write_json(const FamiliesReport& report, const TextSink& sink);
std::string html_page(const FamiliesReport& report);
/// A line per scan of every drive and run, as CSV with a header.
void write_samples(const FamiliesReport& report, const TextSink& sink);

/// The same tables on the terminal and on the page.
std::vector<Table> result_tables(const FamiliesReport& report);
/// Each family's seeds in which the loop made it worse: "slips: 3, 17".
Facts failed_facts(const FamiliesReport& report);
Facts origin_facts(const FamiliesReport& report);
Facts time_facts(const FamiliesReport& report);

}  // namespace parloc::tools::families
