// What the trials of an evaluation may be asked, and whether those so far answer it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/eval/pair_sequence.h"
#include "common/eval/rate_sequence.h"
#include "common/eval/run_trial.h"
#include "tools/report/result_parts.h"
#include "tools/report/text/table.h"

namespace parloc::tools::evaluate {

/// One of both at most.
struct Question {
  std::optional<double> bar;    ///< Is the rate of success at least that?
  std::optional<Config> other;  ///< Is it better with this configuration?
  std::string other_path;       ///< Its file.
  double error = 0.05;          ///< Probability of a wrong answer.
  bool asked() const { return bar || other; }
};

/// What is known after some trials, in their order.
class Answer {
 public:
  Answer(const Question& question, double limit_s);

  /// The next trial, and the same with the other configuration, if there is one.
  void add(const TrialResult& trial, const TrialResult* other);
  bool decided() const;

  Facts facts(std::size_t wanted) const;
  Json json() const;
  /// Trials, beyond these, that probably decide.
  std::optional<std::size_t> more_trials() const;

 private:
  Facts bar_facts(std::size_t wanted) const;
  Facts pair_facts(std::size_t wanted) const;
  Json bar_json() const;
  Json pair_json() const;
  /// Of the pairs that differ, those that the other has won.
  RateCounts won() const { return {pairs_.second_only, pairs_.first_only}; }

  Question question_;
  double limit_s_;
  RateSequence success_, winner_;
  RateCounts trials_;                                  ///< By success.
  PairCounts pairs_;                                   ///< By success, too.
  std::vector<std::uint64_t> here_only_, other_only_;  ///< Seeds with success in one of both.
  RateCounts nearer_;  ///< Of pairs in which both were ever localized: those in which the other's error is
                       ///< smaller, and larger.
};

}  // namespace parloc::tools::evaluate
