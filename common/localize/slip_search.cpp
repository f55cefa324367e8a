#include "common/localize/slip_search.h"

#include "common/error.h"

namespace parloc {
namespace {

/// Near by, places are told apart that are one and the same for a search of the whole map; and more of what
/// the beams say counts before rays do.
SearchConfig near_by(const SearchConfig& whole) {
  SearchConfig c = whole;
  c.separation_m = 0.2;
  c.separation_rad = 0.1;
  c.least_score = 0.0;
  c.least_share = 0.85;
  c.candidates = 12;
  c.most = 1;
  return c;
}

}  // namespace

SlipSearch::SlipSearch(const GridMap& map, const SearchConfig& config, const ComputeConfig& compute,
                       const GlobalSearch* whole)
    : search_(map, near_by(config), compute, whole) {}

std::optional<Hypothesis> SlipSearch::look(const BeamTable& beams, const Pose& expected, const Reach& reach) {
  SearchPrior prior;
  prior.region = SearchPrior::Disc{expected.x_m, expected.y_m, reach.distance_m};
  prior.heading = SearchPrior::Interval{expected.theta_rad, reach.turn_rad};
  try {
    const SearchResult found = search_.search(beams, prior);
    if (!found.hypotheses.empty()) return found.hypotheses.front();
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::input) throw;  // no free cell there: no place either
  }
  return std::nullopt;
}

}  // namespace parloc
