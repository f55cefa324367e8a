// Sums over the beams of a scan, as sum_beams of common/slam/matching/match_scan.h to the bit, in three
// passes: where the beams end (vectors), what is near there in the map (a beam at a time), what that is worth
// (vectors).
#pragma once

#include "common/slam/matching/match_scan.h"

namespace parloc::cpu {

/// Memory of the passes; uninitialised.
struct BeamSums {
  float u[kMostDrawnBeams], v[kMostDrawnBeams];                ///< Where beams end [cells].
  float before_u[kMostDrawnBeams], before_v[kMostDrawnBeams];  ///< Where there must be free space.
  float d[kMostDrawnBeams];                                    ///< As match_beam.

  PARLOC_HD std::int32_t sum(const TileMap& map, const Beams& beams, const MatchPose& p, const MatchRules& r,
                             Ask ask) {
    if (ask == Ask::bound) return sum_beams(map, beams, p, r, ask, 0, 1);
    for (std::size_t m = 0; m < beams.hits; ++m) {
      const EndOfBeam e = end_of_beam(beams, m, p);
      u[m] = e.u, v[m] = e.v, before_u[m] = e.before_u, before_v[m] = e.before_v;
    }
    for (std::size_t m = 0; m < beams.hits; ++m)
      d[m] = match_end(map, {u[m], v[m], before_u[m], before_v[m]});
    return ask == Ask::score ? worth(beams, r, ScoreTerm{}) : worth(beams, r, LikelihoodTerm{});
  }

 private:
  template <class Term>
  PARLOC_HD std::int32_t worth(const Beams& beams, const MatchRules& r, const Term& term) const {
    std::int32_t sum = 0;
    for (std::size_t m = 0; m < beams.hits; ++m) {
      const std::int32_t t = term(d[m], r);
      sum += beams.range_m[m] > r.usable_m ? 0 : t;
    }
    return sum;
  }
};

}  // namespace parloc::cpu
