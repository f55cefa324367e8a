#include "common/localize/slip_search.h"

#include <algorithm>

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

/// Wheels slip about so often, by as much; the farther since all was well, the farther off it may be.
constexpr double kSlipsPer_s = 1.0 / 60.0, kLeastSlipOdds = 0.002, kMostSlipOdds = 0.2;
constexpr double kSlipSigma_m = 0.3, kSlipSigma_rad = 0.2;
constexpr double kSlipGrowth_m = 0.05, kSlipGrowth_rad = 0.02;  ///< Per metre since all was well.
/// After a scan that nothing explained: so often is looked so much wider, which takes eight times as long,
/// for what is so much rarer.
constexpr std::size_t kWideLooks = 6;
constexpr double kWider = 2.0, kRarer = 0.03;
constexpr double kReachSigmas = 3.5;  ///< How far is looked.

}  // namespace

SlipSearch::Reach reach_of(const SlipPrior& slip) {
  return {kReachSigmas * slip.sigma_m, kReachSigmas * slip.sigma_rad};
}

SlipPrior slip_prior(const Pose& tracked, double elapsed_s, double since_well_m, std::size_t unexplained) {
  const bool wide = unexplained > 0 && unexplained <= kWideLooks;
  const double wider = wide ? kWider : 1.0, rarer = wide ? kRarer : 1.0;
  return {tracked, wider * kSlipSigma_m + kSlipGrowth_m * since_well_m,
          wider * kSlipSigma_rad + kSlipGrowth_rad * since_well_m,
          rarer * std::clamp(elapsed_s * kSlipsPer_s, kLeastSlipOdds, kMostSlipOdds)};
}

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
