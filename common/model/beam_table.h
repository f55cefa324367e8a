// The beams of one scan as every particle reads them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/model/scan_shape.h"

namespace parloc {

/// Most beams that are used of a scan.
constexpr std::size_t kMaxBeams = 4096;

/// Structure of arrays, one entry per usable beam: first the `hits`, then the misses (nothing within range).
/// Everything is in the base frame at the scan's time; end points in cells, for hits only.
struct BeamTable : ScanShape {
  /// Where each beam starts, along x [m]: they differ with several LiDARs, or one that moves during its scan.
  std::vector<float> origin_x;
  std::vector<float> origin_y;       ///< And along y [m].
  std::vector<float> direction_x;    ///< Where it looks: a unit vector along x,
  std::vector<float> direction_y;    ///< and along y.
  std::vector<float> range_m;        ///< Measured; range_max_m for a miss.
  std::vector<float> short_density;  ///< z_short lambda exp(-lambda range): the beam model's constant.
  std::vector<float> end_x;          ///< Where it ends, along x [cells].
  std::vector<float> end_y;          ///< And along y [cells].
};

/// All of them, in the order of common/filter/stages.h.
inline constexpr std::array kBeamArrays = {
    &BeamTable::origin_x, &BeamTable::origin_y,      &BeamTable::direction_x, &BeamTable::direction_y,
    &BeamTable::range_m,  &BeamTable::short_density, &BeamTable::end_x,       &BeamTable::end_y};

}  // namespace parloc
