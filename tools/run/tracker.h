// The bare particle filter, or the closed loop around it: what a run drives.
#pragma once

#include <variant>

#include "common/config/config.h"
#include "common/filter/particle_filter.h"
#include "common/localize/localizer.h"
#include "tools/run/start_pose.h"

namespace parloc::tools {

class Tracker {
 public:
  /// The closed loop if `judged`.
  Tracker(const Config& config, const GridMap& map, bool judged);

  void start(const StartPose& start);
  void add_odometry(double stamp_s, const Pose& odometry);
  /// Of the bare filter `health` says nothing.
  LocalizerEstimate step(const Pose& odometry, const Scan& scan);

  bool judged() const { return std::holds_alternative<Localizer>(engine_); }
  const ParticleFilter& filter() const;

 private:
  std::variant<ParticleFilter, Localizer> engine_;
};

}  // namespace parloc::tools
