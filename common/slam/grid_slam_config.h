// What grid SLAM reads.
#pragma once

#include "common/filter/steps/step_config.h"
#include "common/slam/slam_config.h"

namespace parloc {

/// Everything that a GridSlam reads.
struct GridSlamConfig : StepConfig {
  /// With the defaults of mapping where they differ from those of filters.
  GridSlamConfig() {
    scan.max_beams = 180;  // at most kMostSlamBeams
    update_min_d = update_min_a = 0.25;
  }

  SlamConfig slam;  ///< Of mapping.
};

/// As validate(FilterConfig).
void validate(const GridSlamConfig& config);

}  // namespace parloc
