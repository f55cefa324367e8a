// How well one pose explains a whole scan: below the lattice, and with rays.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/map/grid_map.h"
#include "common/model/beams.h"
#include "common/search/scan_evidence.h"
#include "common/search/search_map.h"

namespace parloc {

/// Shares of a scan's beams (hits and misses), and what they say.
struct PoseVerdict {
  double explained = 0.0;  ///< End at a wall that the ray meets, or both see nothing.
  double through = 0.0;    ///< Go on where the map has a wall.
  double unmapped = 0.0;   ///< End before the map's wall.
  double evidence = 0.0;   ///< How much they speak for it [nat per beam] (ScanEvidence).
};

class PoseEvidence {
 public:
  /// `search` outlives this.
  PoseEvidence(const GridMap& map, const SearchMap& search);

  /// Moves a pose (grid frame) to where the field fits best close by: no farther than about a cell and
  /// `heading_step_rad`, and only to free cells. Returns its score, 0 to 1: the mean value of the hits;
  /// `tried` grows by the number of poses that were looked at.
  double refine(const BeamTable& beams, double heading_step_rad, Pose& pose, std::int64_t& tried) const;
  /// As ScanEvidence::learn, for the LiDARs of `judge`.
  std::size_t learn(float range_max_m, std::size_t places) { return evidence_.learn(range_max_m, places); }
  void forget() { evidence_.forget(); }
  PoseVerdict judge(const BeamTable& beams, const Pose& pose);

 private:
  double score(const BeamTable& beams, const Pose& pose) const;
  bool is_free(const Pose& pose) const;

  const SearchMap& search_;
  SearchGrid grid_;
  ScanEvidence evidence_;
  double resolution_m_;
};

}  // namespace parloc
