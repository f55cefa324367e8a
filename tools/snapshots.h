// Keeps the filter's state at several times of a run whose length is not known beforehand.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "common/filter/particle_filter.h"
#include "common/io/report.h"

namespace parloc::tools {

/// Takes every stride-th step; when there are more than `most`, every other one is dropped and the stride
/// doubled. So they are even over the run, their memory is bounded, and which steps they are depends on the
/// count of steps alone.
class SnapshotKeeper {
 public:
  /// After each step.
  void offer(const ParticleFilter& filter, const Pose& estimate, const Scan& scan);
  /// After the last step, which is always kept.
  void finish(const ParticleFilter& filter, const Pose& estimate, const Scan& scan);
  std::vector<Snapshot> take() { return std::move(kept_); }

 private:
  static constexpr std::size_t most = 12;
  std::vector<Snapshot> kept_;
  std::size_t stride_ = 1;
  std::size_t offered_ = 0;
  bool last_kept_ = false;
};

}  // namespace parloc::tools
