// What many trials say together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/eval/calibration.h"
#include "common/eval/result_stream.h"
#include "common/eval/run_trial.h"
#include "common/eval/spread.h"

namespace parloc {

/// A mean over independent trials with its 95 % interval: mean +- 1.96 standard deviations / sqrt(trials).
struct MeanInterval {
  std::size_t count = 0;
  double mean = 0.0, low = 0.0, high = 0.0;  ///< The bounds are NaN for fewer than two trials.
};
MeanInterval mean_interval(const std::vector<double>& values);

struct TrialSummary {
  std::size_t trials = 0, samples = 0;
  double unmapped = 0.0;  ///< Share of the simulated hits that are on clutter; NaN for recorded trials.
  Rate success;           ///< Localized within the limit.
  Rate localized;         ///< At all.
  Rate right_after;       ///< Of the localized: never wrong since, to the end of the trial.
  Spread localize_s;
  Rate tracked_before;  ///< kidnap: right and `tracking` until then; only these had something to notice.
  Rate noticed;         ///< kidnap: within the time of grace.
  Spread notice_s;      ///< kidnap
  Rate confident_wrong, confident_wrong_1s;  ///< Trials with any such sample, and with 1 s of it or more.
  double driven_s = 0.0, right_s = 0.0, wrong_s = 0.0;
  std::size_t false_lost = 0;
  double false_lost_per_hour = 0.0;  ///< Of driving while right.
  double missed_lost = 0.0;          ///< Share of the wrong time in which it says `tracking`.
  double rmse_m = 0.0;               ///< Over all samples since the localization.
  MeanInterval nees;                 ///< Of the trials' means since the localization; 3 is right.
  Calibration calibration;           ///< Of the probability, over all samples.
  double searches_mean = 0.0, searches_most = 0.0;  ///< Per trial.
  Spread step_ms, search_ms;          ///< Steps without and with a search: what the machine makes of them.
  std::vector<std::uint64_t> failed;  ///< Seeds without success, in order.
};

bool succeeded(const TrialOutcome& outcome, double limit_s);

/// Depends on the order of `trials` in the last bits of sums only: give them in the order of their seeds.
/// Goes through them once, and keeps some 40 bytes of each.
TrialSummary summarise(const TrialPlan& plan, double limit_s, const ResultStream<TrialResult>& trials);

}  // namespace parloc
