// A localizer on one log with known truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "common/eval/sample_mark.h"
#include "common/eval/trial.h"
#include "common/localize/localizer.h"

namespace parloc {

struct TrialResult {
  std::uint64_t seed = 0;
  double begun_s = 0.0;  ///< Stamp of the first scan.
  Pose start;            ///< The truth where it had to find itself: at the first scan, or once kidnapped.
  std::vector<TrialSample> samples;  ///< At the scans whose true pose is known.
  std::vector<SampleMark> marks;     ///< Of the same, for statistics; stay where `samples` are not kept.
  TrialOutcome outcome;
  std::size_t searches = 0;
  std::size_t hits = 0, unmapped = 0;  ///< As the log has them.
};

std::vector<SampleMark> marks_of(const TrialPlan& plan, const std::vector<TrialSample>& samples);

/// Runs the trial from its start; nothing of what the localizer did before counts. `keep_going`, if given, is
/// told the fraction done after every scan; false ends the trial, which then has no result. Throws
/// Error{input} for a log without a scan, without any truth, or, if the start is to be given, without the
/// truth there.
std::optional<TrialResult> run_trial(Localizer& localizer, const TrialPlan& plan, const TrialLog& log,
                                     std::uint64_t seed,
                                     const std::function<bool(double fraction)>& keep_going = {});

}  // namespace parloc
