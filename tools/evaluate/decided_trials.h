// The trials of an evaluation, up to where they answer what was asked.
#pragma once

#include <cstddef>
#include <vector>

#include "tools/evaluate/question.h"
#include "tools/evaluate/trials.h"

namespace parloc::tools::evaluate {

struct DecidedTrials {
  std::vector<TrialResult> trials;  ///< In the order of the items; of a pair the first.
  std::size_t dropped = 0;          ///< Were finished beyond the last one that counts.
  double trial_s = 0.0;             ///< Mean time, of a pair for both together; NaN without one.
};

/// The trials up to the first at which `answer`, which is told of them one by one in the order of
/// request.items, is decided: the same ones for any number of jobs. What ran beyond it is dropped. If `stop`
/// said so before, those up to the first that is missing.
DecidedTrials trials_until_decided(TrialsRequest request, const LogSource& source, const GridMap& map,
                                   Answer& answer);

/// 0 to n - 1 in an order that is drawn once for all, so that the first ones are a fair sample: the starts of
/// a log are in the order of its places.
std::vector<std::size_t> shuffled(std::size_t n);

}  // namespace parloc::tools::evaluate
