#include "common/search/search_task.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

std::int32_t block_of(double x_m, double cell_m, std::int32_t blocks) {
  const double block = std::floor(x_m / (cell_m * kBlockCells));
  return static_cast<std::int32_t>(std::clamp(block, 0.0, static_cast<double>(blocks)));
}

bool block_has_pose(const SearchTask& t, std::int32_t block_i, std::int32_t block_j) {
  if (t.grid.free_blocks[std::int64_t{block_j} * t.grid.blocks_x() + block_i] == 0) return false;
  for (std::int32_t n = 0; n < kBlockPoses; ++n)
    if (pose_counts(t, block_i * kBlockCells + n % kBlockCells, block_j * kBlockCells + n / kBlockCells))
      return true;
  return false;
}

bool has_pose(const SearchTask& t) {
  for (std::int32_t j = t.block_j; j < t.block_end_j; ++j)
    for (std::int32_t i = t.block_i; i < t.block_end_i; ++i)
      if (block_has_pose(t, i, j)) return true;
  return false;
}

void set_region(const SearchMap& map, const Pose& T_map_grid, const SearchPrior::Disc& disc, SearchTask& t) {
  if (!std::isfinite(disc.x_m) || !std::isfinite(disc.y_m) || !(disc.radius_m >= 0.0) ||
      !std::isfinite(disc.radius_m))
    throw Error(ErrorKind::input, "search region: expected a finite place and a radius from 0 up");
  const Pose centre = relative({disc.x_m, disc.y_m, 0.0}, T_map_grid);
  const double half_cells = 2.0 / map.cell_m;
  constexpr double far = 1e8;  // beyond any map
  const auto whole = [](double x) { return static_cast<std::int64_t>(std::floor(x + 0.5)); };
  t.region.x = whole(std::clamp(centre.x_m * half_cells, -far, far));
  t.region.y = whole(std::clamp(centre.y_m * half_cells, -far, far));
  const double radius = std::min(disc.radius_m * half_cells, 4.0 * far);
  t.region.squared_radius = static_cast<std::int64_t>(std::floor(radius * radius));
  const double reach_m = disc.radius_m + map.cell_m;  // the centre was rounded
  t.block_i = block_of(centre.x_m - reach_m, map.cell_m, t.block_end_i);
  t.block_j = block_of(centre.y_m - reach_m, map.cell_m, t.block_end_j);
  t.block_end_i = std::min(t.block_end_i, block_of(centre.x_m + reach_m, map.cell_m, t.block_end_i) + 1);
  t.block_end_j = std::min(t.block_end_j, block_of(centre.y_m + reach_m, map.cell_m, t.block_end_j) + 1);
}

void set_headings(const Pose& T_map_grid, const SearchPrior::Interval& interval, SearchTask& t) {
  if (!std::isfinite(interval.heading_rad) || !(interval.tolerance_rad >= 0.0))
    throw Error(ErrorKind::input, "search heading: expected a finite angle and a tolerance from 0 up");
  const double step_rad = 2.0 * kPi / t.headings;
  if (interval.tolerance_rad >= kPi) return;
  const double middle = wrap64(interval.heading_rad - T_map_grid.theta_rad);
  // At least the nearest heading on either side.
  const double low = std::floor((middle - interval.tolerance_rad) / step_rad);
  const double high = std::floor((middle + interval.tolerance_rad) / step_rad) + 1.0;
  const auto first = static_cast<std::int32_t>(low);
  t.first_heading = (first % t.headings + t.headings) % t.headings;
  t.heading_count = std::min(t.headings, static_cast<std::int32_t>(high) - first + 1);
}

}  // namespace

SearchTask make_search_task(const SearchMap& map, const Pose& T_map_grid, const std::string& name,
                            const SearchConfig& config, const SearchScan& scan, const SearchPrior& prior) {
  SearchTask t;
  t.grid = map.view();
  t.beams = scan.beams;
  t.headings = t.heading_count = scan.headings;
  t.block_end_i = t.grid.blocks_x();
  t.block_end_j = t.grid.blocks_y();
  if (prior.region) {
    set_region(map, T_map_grid, *prior.region, t);
    if (!has_pose(t)) throw Error(ErrorKind::input, name + ": the search region has no free cell");
  }
  if (prior.heading) set_headings(T_map_grid, *prior.heading, t);
  const double full = static_cast<double>(kMostValue) * scan.beams;
  t.least = std::max(1u, static_cast<std::uint32_t>(std::floor(config.least_score * full)));
  t.share_1024th = static_cast<std::uint32_t>(std::floor(config.least_share * 1024.0));
  t.grid = map.shape;
  return t;
}

}  // namespace parloc
