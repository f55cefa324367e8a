// What a kernel is told of a scan besides its arrays.
#pragma once

#include <cstddef>

namespace parloc {

/// Of a scan's beams, what is one number. Lengths in metres.
struct ScanShape {
  std::size_t count = 0;
  std::size_t hits = 0;
  float range_max_m = 0.0f;
  float first_origin_x = 0.0f, first_origin_y = 0.0f;  ///< Where the first beam starts; 0 without beams.
  float origin_spread_m = 0.0f;  ///< No beam starts farther from there than this; 0: all start there.
  float origin_reach_m = 0.0f;   ///< Nor farther than this from the base.
};

}  // namespace parloc
