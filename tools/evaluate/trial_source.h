// Where the trials of an evaluation come from: simulated drives, or parts of a recorded log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "common/eval/trial.h"
#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"

namespace parloc::tools::evaluate {

class TrialSource {
 public:
  virtual ~TrialSource() = default;
  /// The trial of a seed. May be called from several threads.
  virtual TrialLog trial(std::uint64_t seed) const = 0;
  virtual std::string what() const = 0;  ///< For people: where the trials come from.
};

/// A random drive per seed through `map`. Throws Error{input} for a map without room to drive.
std::unique_ptr<TrialSource> simulated_trials(const TrialPlan& plan, const Scenario& scenario, GridMap map,
                                              const std::string& name);

struct RecordedPlan {
  std::string log, truth;  ///< Files.
  std::size_t starts = 20;
  double duration_s = 0.0;  ///< 0: to the end of the log.
};

/// Seed k, from 1 to `starts`, is the log from its kth start time on; these are spread evenly, the first one
/// at the first scan. Reads both files: throws Error{input} as their readers, for a log without a scan, and
/// for a truth of another time.
std::unique_ptr<TrialSource> recorded_trials(const RecordedPlan& plan);

}  // namespace parloc::tools::evaluate
