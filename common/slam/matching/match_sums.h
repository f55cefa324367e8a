// What a search for a pose asks of the map: sums over the beams of a scan.
#pragma once

#include "common/slam/matching/wide_search.h"

namespace parloc {

enum class Ask {
  score,       ///< How many beams fit [1/65536].
  likelihood,  ///< Log-likelihood [nat / 65536].
  bound,       ///< No pose of a block of WideSearch has a higher score.
};

/// Over every `step`-th beam from `first` on.
PARLOC_HD std::int32_t sum_beams(const TileMap& map, const Beams& beams, const MatchPose& pose,
                                 const MatchRules& rules, Ask ask, std::size_t first, std::size_t step) {
  std::int32_t sum = 0;
  if (ask == Ask::score) {
    for (std::size_t m = first; m < beams.hits; m += step)
      sum += match_term(map, beams, m, pose, rules, ScoreTerm{});
  } else if (ask == Ask::likelihood) {
    for (std::size_t m = first; m < beams.hits; m += step)
      sum += match_term(map, beams, m, pose, rules, LikelihoodTerm{});
  } else {
    for (std::size_t m = first; m < beams.hits; m += step) sum += block_term(map, beams, m, pose, rules);
  }
  return sum;
}

}  // namespace parloc
