// The last part of a global search: what rays say of the places that the lattice gave.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"
#include "common/model/beams.h"
#include "common/search/global_search.h"
#include "common/search/hypotheses.h"
#include "common/search/pose_evidence.h"
#include "common/search/search_config.h"
#include "common/search/search_map.h"

namespace parloc {

/// In slices: each place is moved to where the scan fits best and judged, then they are ranked, the most
/// likely first, and those too close to a better one left out. Everything keeps its capacity.
class JudgePlaces {
 public:
  /// `search` outlives this. Throws Error{input} for a map without free cells.
  JudgePlaces(const GridMap& map, const SearchMap& search, const SearchConfig& config);

  /// Both outlive the judging. `headings` of the lattice.
  void begin(const BeamTable& beams, const std::vector<LatticePose>& places, std::int32_t headings);
  /// Does about so much work [search_work.h], but something; returns how much it was.
  std::int64_t advance(std::int64_t work);
  bool done() const;
  /// All at once, what begin() and advance() would learn of a LiDAR that reaches so far [m].
  void learn(float range_max_m) { (void)evidence_.learn(range_max_m, ScanEvidence::kPlaces); }
  void forget() { evidence_.forget(); }
  /// Fills in what has to do with hypotheses; once done.
  void report(SearchResult& result) const;

 private:
  std::int64_t step(std::int64_t work);
  std::int64_t judge_next();
  std::int64_t rank_next();

  SearchConfig config_;
  Pose T_map_grid_;
  double cell_m_;
  PoseEvidence evidence_;
  const BeamTable* beams_ = nullptr;
  const std::vector<LatticePose>* places_ = nullptr;
  std::int32_t headings_ = 0;
  std::size_t to_learn_ = 0;          // random places
  std::vector<Hypothesis> judged_;    // by place
  std::vector<std::uint32_t> order_;  // of the judged, the most likely first
  std::size_t ranked_ = 0;            // of those
  std::vector<Hypothesis> kept_;
  double total_weight_ = 0.0;  // of those
};

}  // namespace parloc
