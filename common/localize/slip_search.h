// Where the robot is if its wheels have slipped: near where they say that it is.
#pragma once

#include <memory>
#include <optional>

#include "common/filter/pose/pose_guess.h"
#include "common/filter/steps/compute_config.h"
#include "common/map/grid_map.h"
#include "common/model/beams.h"
#include "common/search/global_search.h"
#include "common/search/search_config.h"

namespace parloc {

/// A search of a small part of the map. Deterministic on every machine.
class SlipSearch {
 public:
  /// `whole` is a search of the same map, with which it shares what depends on that; it may be null.
  SlipSearch(const GridMap& map, const SearchConfig& config, const ComputeConfig& compute,
             const GlobalSearch* whole);

  /// As GlobalSearch::learn.
  void learn(double range_max_m) { search_.learn(range_max_m); }

  /// How far the robot may be from where it is expected.
  struct Reach {
    double distance_m, turn_rad;
  };
  /// The place within reach that explains the scan best; nothing if there is none, or no free cell. Map
  /// frame.
  std::optional<Hypothesis> look(const BeamTable& beams, const Pose& expected, const Reach& reach);

 private:
  GlobalSearch search_;
};

/// The farther the robot has come since all was well, the farther off it may be; and if nothing near by
/// explained the last scans, so many of them, it has slipped more than wheels do every day.
SlipPrior slip_prior(const Pose& tracked, double elapsed_s, double since_well_m, std::size_t unexplained);
/// How far is looked.
SlipSearch::Reach reach_of(const SlipPrior& slip);

}  // namespace parloc
