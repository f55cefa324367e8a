#include "common/slam/slam_backend.h"

#include <algorithm>

namespace parloc {

static_assert(kMostSlamBeams <= kMostDrawnBeams);

ProposeRules bind_propose_rules(const SlamConfig& c) {
  const double cell_sq = c.resolution * c.resolution;
  ProposeRules r;
  r.proposal = c.proposal;
  r.match.inv_resolution = static_cast<float>(1.0 / c.resolution);
  r.match.usable_m = static_cast<float>(c.usable_range);
  r.match.score_rate = static_cast<float>(-cell_sq / c.sigma_score);
  r.match.likelihood_rate = static_cast<float>(-cell_sq / c.sigma_likelihood);
  r.match.no_match = static_cast<std::int32_t>(-0.5 / c.sigma_likelihood * static_cast<double>(kScoreUnits));
  r.search = bind_search_rules(c.resolution, c.search_xy, c.search_theta, c.search_bias);
  r.climb = {static_cast<float>(c.step_xy), static_cast<float>(c.step_theta), c.iterations};
  r.box = {c.box_xy, c.box_theta};
  r.beta_weight = static_cast<float>(c.beta_weight);
  r.beta_proposal = static_cast<float>(c.beta_proposal);
  r.min_score = static_cast<float>(c.min_score * static_cast<double>(kScoreUnits));
  r.floor_xy = static_cast<float>(c.motion_floor_xy);
  r.floor_theta = static_cast<float>(c.motion_floor_theta);
  return r;
}

MatcherRules bind_matcher_rules(const SlamConfig& c) {
  const ProposeRules r = bind_propose_rules(c);
  return {bind_draw_rules(c), r.match, r.climb, c.resolution};
}

DrawRules bind_draw_rules(const SlamConfig& c) {
  return {static_cast<float>(1.0 / c.resolution), static_cast<float>(c.usable_range / c.resolution),
          static_cast<float>(c.clear_range / c.resolution)};
}

void bind_scan(ProposeRules& rules, const BeamTable& scan, bool empty) {
  rules.motion.spread_xy = std::max(rules.floor_xy, rules.motion.spread_xy);
  rules.motion.spread_theta = std::max(rules.floor_theta, rules.motion.spread_theta);
  rules.beams = empty ? 0 : count_matched(scan.range_m.data(), scan.hits, rules.match);
}

void inherit(std::vector<float>& values, const std::vector<std::uint32_t>& ancestor) {
  const std::vector<float> before = values;
  for (std::size_t j = 0; j < values.size(); ++j) values[j] = before[ancestor[j]];
}

std::unique_ptr<SlamBackend> make_slam_backend(BackendChoice choice, const SlamBackendConfig& config,
                                               std::string& why) {
  if (takes_cuda(choice, why)) {
    if constexpr (PARLOC_WITH_CUDA != 0) return make_cuda_slam_backend(config);
  }
  return make_cpu_slam_backend(config);
}

}  // namespace parloc
