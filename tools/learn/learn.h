// The sensor model of a LiDAR, from a log whose poses are known: what `parloc learn` fits and draws.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "common/eval/fit_mixture.h"
#include "common/filter/filter_config.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/map/grid_map.h"

namespace parloc::tools {

struct RangePairsOfLog {
  RangePairs ranges;
  std::size_t scans = 0, without_pose = 0;
  Trajectory odometry;  ///< What the scans carry, one row each, in file order.
};

/// The beams that the configuration chooses of each scan, and what the map says from the scan's pose: the
/// ranges that the filter itself would compare. `poses` is the truth, or the estimate of a run. A sensor
/// whose maximum range changes within the log is an Error{input}. `keep_going` as in simulate().
RangePairsOfLog collect_range_pairs(const GridMap& map, LogReader& log, const Trajectory& poses,
                                    const FilterConfig& config,
                                    const std::function<bool(double fraction)>& keep_going);

/// One PNG: density over measured minus expected range, logarithmic, of the beams that hit something where
/// the map has a wall in reach: as measured, and as the mixture says for the same expected ranges. Throws
/// Error{output}.
void write_mixture_picture(const std::string& path, const RangePairs& ranges, const Mixture& mixture);

}  // namespace parloc::tools
