// Measured and expected ranges of a log whose poses are known.
#pragma once

#include <cstddef>
#include <functional>

#include "common/eval/fit_mixture.h"
#include "common/filter/filter_config.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/map/grid_map.h"

namespace parloc::tools {

struct RangePairsOfLog {
  RangePairs ranges;
  std::size_t scans = 0, without_pose = 0;
};

/// The beams that the configuration chooses of each scan, and what the map says from the scan's pose: the
/// ranges that the filter itself would compare. `poses` is the truth, or the estimate of a run. A sensor
/// whose maximum range changes within the log is an Error{input}. `keep_going` as in simulate().
RangePairsOfLog collect_range_pairs(const GridMap& map, LogReader& log, const Trajectory& poses,
                                    const FilterConfig& config,
                                    const std::function<bool(double fraction)>& keep_going);

}  // namespace parloc::tools
