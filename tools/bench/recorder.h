// Measures rows one after another and keeps what is finished, whatever goes wrong on the way.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tools/bench/results.h"
#include "tools/bench/steps/measure.h"
#include "tools/bench/steps/rig.h"
#include "tools/bench/steps/scenes.h"

namespace parloc::tools::bench {

class Recorder {
 public:
  /// `total`: how many rows there will be, for the progress.
  Recorder(const Control& control, Results& results, std::size_t total)
      : control_(control), results_(results), total_(total) {}

  /// False when the user asked to stop; what comes after need not be tried.
  bool go_on();
  /// Counts one more piece of the work, for the progress; `what` is short, to fit a line of a terminal.
  void tell(const std::string& what);
  bool out_of_time() const { return control_.out_of_time(); }

  /// Null if there is no memory or no time for it, or if the backend refuses; `why` says so then.
  std::unique_ptr<Rig> make_rig(const Scene& scene, Cloud cloud, std::size_t variant, std::int64_t particles,
                                std::string& why);
  /// Times the row on the rig and keeps it; a null rig is noted as skipped because of `why`.
  void measure_row(Rig* rig, Row row, const std::string& why);
  /// Times one size that is no row of its own; empty if that failed (noted) or was interrupted.
  std::optional<TimeSummary> measure_alone(Rig& rig, const Row& row);

 private:
  std::optional<TimeSummary> time_steps(Rig& rig, const Row& row);
  void add_stages(Rig& rig, Row& row);
  std::string name(const Row& row) const;

  const Control& control_;
  Results& results_;
  std::size_t total_, done_ = 0;
};

}  // namespace parloc::tools::bench
