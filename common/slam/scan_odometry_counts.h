// What odometry from scans alone (common/slam/scan_odometry.h) says of its work.
#pragma once

#include <cstddef>

namespace parloc {

/// What became of the scans.
struct ScanOdometryCounts {
  std::size_t scans = 0;     ///< All.
  std::size_t unfit = 0;     ///< Of them fitted nowhere near, or had too few beams: the prediction was kept.
  std::size_t far = 0;       ///< Were looked for, and found, in the wider window.
  std::size_t new_maps = 0;  ///< Times that nothing fitted for so long that the local map was begun anew.
};

}  // namespace parloc
