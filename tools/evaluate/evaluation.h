// An evaluation with its results, and the forms in which it is told.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/eval/result_stream.h"
#include "common/eval/trial_summary.h"
#include "common/localize/localizer.h"
#include "common/map/grid_map.h"
#include "tools/evaluate/question.h"
#include "tools/report/machine/machine.h"
#include "tools/report/result_parts.h"
#include "tools/report/text/table.h"

namespace parloc::tools::evaluate {

struct Evaluation {
  std::string command, date;  ///< deciding_command(); UTC.
  Machine machine;
  bool recorded = false;         ///< A log; else simulated.
  std::string source, map_path;  ///< Where the trials come from, for people; what was localized on.
  TrialPlan plan;
  double limit_s = 0.0;
  std::uint64_t first_seed = 1;
  std::size_t wanted = 0;
  int jobs = 1;
  std::size_t shards = 0;  ///< That the trials come from; none if they were computed here.
  Config config;
  bool interrupted = false;  ///< Fewer trials than wanted.
  double wall_s = 0.0;       ///< Of shards, all of theirs together.
  double trial_s = 0.0;      ///< Mean time of one on a core; of a pair for both. NaN without one.
  std::size_t dropped = 0;   ///< Trials that ran beyond the one at which the question was decided.
  Question question;
  ResultStream<TrialResult> trials;
  TrialSummary summary;
  std::optional<Answer> answer;  ///< If there is a question.
};

/// More trials: those that a question needs to be decided, else 1000.
std::size_t next_trials(const Evaluation& e);

const char* name_of(TrialTask task);

/// What a reader wants to know first, as sentences: name and value.
Facts result_facts(const Evaluation& e);
Facts time_facts(const Evaluation& e);    ///< What depends on the machine.
Facts origin_facts(const Evaluation& e);  ///< What was evaluated, and how.
/// "said 0.0 to 0.1: 12 samples, mean 0.03, right 1.2 %", the bins with samples.
std::vector<std::vector<std::string>> reliability_rows(const Evaluation& e);

std::string terminal_text(const Evaluation& e);
/// Everything that is measured on a clock is in "times".
void write_json(const Evaluation& e, const TextSink& sink);
std::string html_page(const Evaluation& e, const GridMap& map);
/// One line per sample of every trial, as CSV with a header.
void write_samples(const Evaluation& e, const TextSink& sink);

}  // namespace parloc::tools::evaluate
