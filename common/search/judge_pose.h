// How well one pose explains a whole scan: below the lattice, and with rays.
#pragma once

#include <cstdint>
#include <vector>

#include "common/filter/stages.h"
#include "common/map/grid_map.h"
#include "common/map/wall_index.h"
#include "common/model/beams.h"
#include "common/search/search_map.h"

namespace parloc {

/// Shares of a scan's beams (hits and misses), and how likely it is.
struct PoseJudgement {
  double explained = 0.0;       ///< End at a wall that the ray meets, or both see nothing.
  double through = 0.0;         ///< Go on where the map has a wall.
  double unmapped = 0.0;        ///< End before the map's wall.
  double log_likelihood = 0.0;  ///< Of the beam model, mean over the beams.
};

class PoseJudge {
 public:
  /// `search` outlives this.
  PoseJudge(const GridMap& map, const SearchMap& search);

  /// Moves a pose (grid frame) to where the field fits best close by: no farther than about a cell and
  /// `heading_step_rad`, and only to free cells. Returns its score, 0 to 1: the mean value of the hits.
  double refine(const BeamTable& beams, double heading_step_rad, Pose& pose) const;
  PoseJudgement judge(const BeamTable& beams, const Pose& pose) const;

 private:
  double score(const BeamTable& beams, const Pose& pose) const;
  bool is_free(const Pose& pose) const;

  const SearchMap& search_;
  SearchGrid grid_;
  std::vector<std::uint8_t> skip_;
  WallIndex walls_;
  RayMap ray_map_;
  SensorConfig sensor_;
  double resolution_m_;
};

}  // namespace parloc
