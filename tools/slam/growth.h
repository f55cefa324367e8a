// What there is to show of a map in the making.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/slam/grid_slam.h"
#include "tools/report/report.h"

namespace parloc::tools::slam {

/// The work at one moment.
struct Growth {
  Snapshot state;  ///< Of the last scan that was taken in: the most likely one's pose, as many of all as are
                   ///< drawn.
  GridMap
      map;  ///< The most likely particle's; cells are merged when there are more than `most_cells` a side.
  Trajectory path;          ///< Its path, at most `most_poses` of it, evenly.
  double distance_m = 0.0;  ///< Along the whole path.
  std::size_t scans = 0, taken_in = 0, resampled = 0, particles = 0;
  double n_eff = 0.0;
  /// How many different poses the particles have behind them at 0, 25, 50 and 75 % of the scans taken in.
  std::array<std::size_t, 4> distinct{};
  SlamMemory memory;

  static constexpr std::int32_t most_cells = 2000;
  static constexpr std::size_t most_poses = 2000;
};

/// `scans`: how many were read. At least one was taken in.
Growth growth_of(const GridSlam& slam, std::size_t scans);

std::size_t resampled(const std::vector<SlamRecord>& records);
double length_m(const Trajectory& path);
/// At 0, 25, 50 and 75 % of a value by scan; zero of none.
std::array<std::size_t, 4> quarters(const std::vector<std::size_t>& by_scan);

/// For the report.
MapMoment moment_of(const Growth& growth);
/// A picture with the numbers below, for those who wait.
void write_live(const std::string& path, const Growth& growth);

}  // namespace parloc::tools::slam
