// How much a scan speaks for a pose, against any other pose on the map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/search/pose_rays.h"

namespace parloc {

/// The likelihood ratio of the two: each beam's density by the beam model at the pose (SPEC 3.3), and its
/// density at a random place of the map, looking a random way. Where a map is all alike the second is as high
/// as the first, and a scan that fits everywhere tells nothing.
class ScanEvidence {
 public:
  static constexpr std::int64_t kPlaces = 2048;  ///< Rays that chance is learnt from.
  /// Built once per map. Throws Error{input} for a map without free cells.
  explicit ScanEvidence(const GridMap& map);

  /// Mean over the beams, hits and misses, of the logarithm of the ratio [nat]: about 1 to 2 where the robot
  /// is, below 0 where it is not. 0 for a scan without beams. Of a range_max_m that is not known yet the
  /// first call takes milliseconds. Deterministic on every machine.
  /// `lost`: share of the beams that see nothing wherever they look, so that those who do say less.
  double per_beam(const BeamTable& beams, const Pose& pose_in_grid, double lost = 0.0);
  /// Becomes ready for LiDARs that reach so far [m], by at most so many of the random places that are gone
  /// through for it. Returns how many are left: 0 when it is ready. What it learns is the same however it is
  /// sliced.
  std::size_t learn(float range_max_m, std::size_t places);
  /// What was learnt of LiDARs.
  void forget() { chances_.clear(), learning_ = {}; }
  /// What that call would have given for a scan that sees just what the map shows from there: how much a scan
  /// from there can tell at all [nat per beam]. Little before a flat wall, or where most beams meet nothing.
  double attainable() const { return attainable_; }
  /// Expected ranges of that call, by beam [m].
  const std::vector<float>& expected_m() const { return expected_m_; }

 private:
  /// What a beam says anywhere on the map, with LiDARs that reach so far.
  struct Chance {
    float range_max_m = 0.0f;
    std::vector<float> log_hit;  // log density by range, in equal bins up to range_max_m
    std::vector<float> best;     // evidence of a beam that ends just where the map has its wall, likewise
    float log_miss = 0.0f;       // log probability
  };
  /// Sums of probabilities over the places that were gone through.
  struct Learning {
    float range_max_m = 0.0f;
    std::vector<double> hit;  // empty: nothing is being learnt
    double miss = 0.0;
    std::size_t places = 0;
  };
  const Chance* known(float range_max_m) const;
  void add_place(std::size_t place);
  Chance learnt_chance() const;

  PoseRays rays_;
  std::vector<float> anywhere_x_m_, anywhere_y_m_, anywhere_heading_rad_;  // random poses on free cells
  std::vector<Chance> chances_;                                            // the newest last
  Learning learning_;
  std::vector<float> expected_m_;  // of the scan at hand
  double attainable_ = 0.0;        // likewise
};

}  // namespace parloc
