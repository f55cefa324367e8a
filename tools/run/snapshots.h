// Keeps the filter's state at several times of a run whose length is not known beforehand.
#pragma once

#include <vector>

#include "common/filter/particle_filter.h"
#include "tools/report/even_sample.h"
#include "tools/report/report.h"

namespace parloc::tools {

/// As EvenSample says.
class SnapshotKeeper {
 public:
  /// After each step.
  void offer(const ParticleFilter& filter, const Pose& estimate, const Scan& scan);
  /// After the last step, which is always kept.
  void finish(const ParticleFilter& filter, const Pose& estimate, const Scan& scan);
  std::vector<Snapshot> take() { return kept_.take(); }

 private:
  EvenSample<Snapshot> kept_{12};
};

}  // namespace parloc::tools
