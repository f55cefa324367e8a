// What a filter on the distance field reads.
#pragma once

#include <cstdint>

#include "common/filter/filter_config.h"
#include "common/flow/flow_config.h"

namespace parloc {

/// Everything that a FlowFilter reads.
struct FlowFilterConfig : StepConfig {
  /// With the defaults of flows where they differ from those of other filters.
  FlowFilterConfig() { scan.max_beams = 360; }

  std::int64_t particles = 2000;  ///< Kalman filters have none.
  ResampleConfig resample;        ///< pfpf
  FlowConfig flow;                ///< Of the method.
};

/// As validate(FilterConfig).
void validate(const FlowFilterConfig& config);

}  // namespace parloc
