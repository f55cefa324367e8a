// THE STAGES OF GRID SLAM, under the same names in cpu/ and cuda/. Poses are in the map frame, whose origin
// is where the robot started; cells are counted from there.
//
// clang-format off
// | stage          | reads                                     | writes                                                     |
// |----------------|-------------------------------------------|------------------------------------------------------------|
// | propose        | poses, maps, scan, motion                 | poses, log_weight, likelihood                              |
// | normalise_scan | log_weight                                | weights, N_eff, resample (common/filter/stages.h)          |
// | resample       | poses, weights                            | ancestor, the other pose buffer (likewise)                 |
// | inherit_tiles  | ancestor, tables, likelihood              | the other tables, likelihood; references                   |
// | mark_tiles     | poses, scan                               | touched: tiles that the scan will write                    |
// | find_new_tiles | touched, tables, references               | which of them a particle has to itself not yet             |
// | assign_tiles   | touched, tables, references               | tables: a tile of its own wherever a particle will write   |
// | register_scan  | poses, scan, touched, tables              | cells; occupied bits of the touched tiles                  |
// clang-format on
#pragma once

#include "common/slam/matching/draw.h"
#include "common/slam/propose.h"

namespace parloc {

/// Of all stages, so much as they need.
struct SlamArgs {
  ProposeRules rules;
  DrawRules draw;
  Beams beams;
  SlamMaps maps;
  Particles particles;
  float* likelihood = nullptr;      ///< [N] Sum of log-weights over the whole way.
  std::uint8_t* touched = nullptr;  ///< [N][span.size()] 1: the scan comes there.
};

PARLOC_HD SlamPose slam_pose(const Particles& p, std::size_t i) {
  return {p.x[i], p.y[i], p.theta[i]};
}

}  // namespace parloc
