#include "common/slam/matching/scan_matcher.h"

#include <fmt/format.h>

#include <cmath>

#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "common/math/portable64.h"

namespace parloc {

SearchRules bind_search_rules(double resolution_m, double reach_m, double reach_rad, double bias) {
  constexpr double kFinest_rad =
      0.015;  // half of it moves an end point 10 m away by 7.5 cm: the climb gets it
  SearchRules r;
  r.bias = static_cast<float>(bias);
  r.resolution_m = static_cast<float>(resolution_m);
  r.cells = static_cast<std::int32_t>(std::ceil(reach_m / resolution_m));
  r.turns = static_cast<std::int32_t>(std::ceil(reach_rad / kFinest_rad));
  r.step_theta = r.turns > 0 ? static_cast<float>(reach_rad / r.turns) : 0.0f;
  r.inv_cells_sq = r.cells > 0 ? 1.0f / static_cast<float>(r.cells * r.cells) : 0.0f;
  r.inv_turns_sq = r.turns > 0 ? 1.0f / static_cast<float>(r.turns * r.turns) : 0.0f;
  const std::int64_t along = WideSearch::blocks_along(r.cells);
  const std::int64_t blocks = (2 * std::int64_t{r.turns} + 1) * along * along;
  if (blocks > WideSearch::kMostBlocks)
    throw Error(
        ErrorKind::config,
        fmt::format("slam.search_xy, slam.search_theta: expected a window of at most {} blocks of {} x "
                    "{} cells, got {}",
                    WideSearch::kMostBlocks, WideSearch::kBlock, WideSearch::kBlock, blocks));
  return r;
}

SlamPose slam_pose(const Pose& p) {
  return {static_cast<float>(p.x_m), static_cast<float>(p.y_m), static_cast<float>(p.theta_rad)};
}

ScanMatch match_of(const FoundPose& found) {
  return {{double{found.pose.x}, double{found.pose.y}, wrap64(double{found.pose.theta})}, found.fit};
}

MatchTask bind_query(const ScanQuery& query, const TileMap& map, const Beams& scan,
                     const MatcherRules& rules) {
  const std::size_t beams = count_matched(query.scan->range_m.data(), query.scan->hits, rules.match);
  return {{query.search, query.climb, beams}, map, scan, slam_pose(query.start)};
}

TileSpan span_with(TileSpan span, const std::vector<ScanDrawing>& drawings, const DrawRules& rules) {
  const double cell_m = 1.0 / static_cast<double>(rules.inv_resolution);
  const double reach_m = static_cast<double>(rules.usable_cells) * cell_m;
  for (const ScanDrawing& d : drawings) {
    const SlamPose at = slam_pose(d.pose);
    span = grown_span(span, {at.x}, {at.y}, reach_m, cell_m);
  }
  return span;
}

std::unique_ptr<ScanMatcher> make_scan_matcher(BackendChoice choice, const ScanMatcherConfig& config) {
  std::string why;
  if (takes_cuda(choice, why)) {
    if constexpr (PARLOC_WITH_CUDA != 0) return make_cuda_scan_matcher(config);
  }
  return make_cpu_scan_matcher(config);
}

}  // namespace parloc
