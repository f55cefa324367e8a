// What a kernel is told of a scan besides its arrays.
#pragma once

#include <cstddef>

namespace parloc {

/// Of a scan's beams, what is one number. Lengths in metres.
struct ScanShape {
  std::size_t count = 0;         ///< Beams.
  std::size_t hits = 0;          ///< Of them ended at something; they come first.
  float range_max_m = 0.0f;      ///< As far as the LiDAR sees.
  float first_origin_x = 0.0f;   ///< Where the first beam starts, along x; 0 without beams.
  float first_origin_y = 0.0f;   ///< And along y.
  float origin_spread_m = 0.0f;  ///< No beam starts farther from there than this; 0: all start there.
  float origin_reach_m = 0.0f;   ///< Nor farther than this from the base.
};

}  // namespace parloc
