#include "common/slam/slam_backend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "common/map/map_limits.h"

namespace parloc {

SearchRules bind_search_rules(const SlamConfig& c, double reach_m, double reach_rad, double bias) {
  constexpr double kFinest_rad =
      0.015;  // half of it moves an end point 10 m away by 7.5 cm: the climb gets it
  SearchRules r;
  r.bias = static_cast<float>(bias);
  r.resolution_m = static_cast<float>(c.resolution);
  r.cells = static_cast<std::int32_t>(std::ceil(reach_m / c.resolution));
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

ProposeRules bind_propose_rules(const SlamConfig& c) {
  const double cell_sq = c.resolution * c.resolution;
  ProposeRules r;
  r.proposal = c.proposal;
  r.match.inv_resolution = static_cast<float>(1.0 / c.resolution);
  r.match.usable_m = static_cast<float>(c.usable_range);
  r.match.score_rate = static_cast<float>(-cell_sq / c.sigma_score);
  r.match.likelihood_rate = static_cast<float>(-cell_sq / c.sigma_likelihood);
  r.match.no_match = static_cast<std::int32_t>(-0.5 / c.sigma_likelihood * static_cast<double>(kScoreUnits));
  r.search = bind_search_rules(c, c.search_xy, c.search_theta, c.search_bias);
  r.climb = {static_cast<float>(c.step_xy), static_cast<float>(c.step_theta), c.iterations};
  r.box = {c.box_xy, c.box_theta};
  r.beta_weight = static_cast<float>(c.beta_weight);
  r.beta_proposal = static_cast<float>(c.beta_proposal);
  r.min_score = static_cast<float>(c.min_score * static_cast<double>(kScoreUnits));
  r.floor_xy = static_cast<float>(c.motion_floor_xy);
  r.floor_theta = static_cast<float>(c.motion_floor_theta);
  return r;
}

DrawRules bind_draw_rules(const SlamConfig& c) {
  return {static_cast<float>(1.0 / c.resolution), static_cast<float>(c.usable_range / c.resolution)};
}

void bind_scan(ProposeRules& rules, const BeamTable& scan, bool empty) {
  rules.motion.spread_xy = rules.floor_xy, rules.motion.spread_theta = rules.floor_theta;
  rules.beams = 0;
  for (std::size_t m = 0; m < scan.hits && !empty; ++m)
    rules.beams += scan.range_m[m] <= rules.match.usable_m ? 1 : 0;
}

void inherit(std::vector<float>& values, const std::vector<std::uint32_t>& ancestor) {
  const std::vector<float> before = values;
  for (std::size_t j = 0; j < values.size(); ++j) values[j] = before[ancestor[j]];
}

TileSpan reached_tiles(const std::vector<float>& x, const std::vector<float>& y, double reach_m,
                       double resolution_m) {
  const double tile_m = kTileCells * resolution_m;
  const auto [x0, x1] = std::minmax_element(x.begin(), x.end());
  const auto [y0, y1] = std::minmax_element(y.begin(), y.end());
  const auto low = [&](float v) { return static_cast<std::int32_t>(std::floor((v - reach_m) / tile_m)) - 1; };
  const auto high = [&](float v) {
    return static_cast<std::int32_t>(std::floor((v + reach_m) / tile_m)) + 2;
  };
  return {low(*x0), low(*y0), high(*x1) - low(*x0), high(*y1) - low(*y0)};
}

namespace {

/// A map that is larger cannot be written, nor held: odometry that jumps must not ask for it.
void expect_a_map(std::int32_t first, std::int32_t size, const std::vector<float>& at, double reach_m,
                  double resolution_m) {
  const double tile_m = kTileCells * resolution_m, most_m = kMaxMapSide * resolution_m;
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  const double from_m = std::min(double{*low} - reach_m, size > 0 ? first * tile_m : double{*low});
  const double to_m = std::max(double{*high} + reach_m, size > 0 ? (first + size) * tile_m : double{*high});
  if (!(to_m - from_m <= most_m && std::fabs(from_m) <= most_m && std::fabs(to_m) <= most_m))
    throw Error(ErrorKind::input,
                fmt::format("slam: expected a place of at most {:.0f} m ({} cells of {} m), found poses that "
                            "are {:.6g} m apart: does the odometry jump?",
                            most_m, kMaxMapSide, resolution_m, to_m - from_m - 2.0 * reach_m));
}

}  // namespace

TileSpan grown_span(const TileSpan& span, const std::vector<float>& x, const std::vector<float>& y,
                    double reach_m, double resolution_m) {
  expect_a_map(span.first_i, span.width, x, reach_m, resolution_m);
  expect_a_map(span.first_j, span.height, y, reach_m, resolution_m);
  const TileSpan near = reached_tiles(x, y, reach_m, resolution_m);
  const std::int32_t i0 = near.first_i, i1 = i0 + near.width, j0 = near.first_j, j1 = j0 + near.height;
  const std::int32_t end_i = span.first_i + span.width, end_j = span.first_j + span.height;
  if (span.width > 0 && i0 >= span.first_i && j0 >= span.first_j && i1 <= end_i && j1 <= end_j) return span;
  constexpr std::int32_t kSpare = 8;  // so that it does not grow with every metre
  const auto least = [&](std::int32_t now, std::int32_t need) { return need < now ? need - kSpare : now; };
  const auto most = [&](std::int32_t now, std::int32_t need) { return need > now ? need + kSpare : now; };
  if (span.width == 0) return {i0 - kSpare, j0 - kSpare, i1 - i0 + 2 * kSpare, j1 - j0 + 2 * kSpare};
  TileSpan s;
  s.first_i = least(span.first_i, i0), s.first_j = least(span.first_j, j0);
  s.width = most(end_i, i1) - s.first_i, s.height = most(end_j, j1) - s.first_j;
  return s;
}

std::vector<std::uint32_t> moved_tables(const std::vector<std::uint32_t>& table, const TileSpan& from,
                                        const TileSpan& to, std::size_t particles) {
  std::vector<std::uint32_t> out(particles * to.size(), kNoTile);
  const std::ptrdiff_t di = from.first_i - to.first_i, dj = from.first_j - to.first_j;
  for (std::size_t p = 0; p < particles; ++p)
    for (std::int32_t j = 0; j < from.height; ++j)
      std::copy_n(
          table.begin() + static_cast<std::ptrdiff_t>(p * from.size()) + std::ptrdiff_t{j} * from.width,
          from.width, out.begin() + static_cast<std::ptrdiff_t>(p * to.size()) + (j + dj) * to.width + di);
  return out;
}

std::vector<std::uint32_t> tiles_named(const std::vector<std::uint32_t>& table) {
  std::vector<std::uint32_t> ids;
  std::vector<bool> seen;
  for (const std::uint32_t id : table) {
    if (id >= seen.size()) seen.resize(id + 1, false);
    if (id != kNoTile && !seen[id]) ids.push_back(id);
    seen[id] = true;
  }
  return ids;
}

std::vector<std::uint32_t> count_references(const std::vector<std::uint32_t>& table, std::size_t tiles) {
  std::vector<std::uint32_t> references(tiles, 0);
  for (const std::uint32_t id : table) ++references[id];
  references[kNoTile] = 1;  // never free
  return references;
}

std::vector<std::uint32_t> first_free(const std::uint32_t* references, std::size_t count) {
  std::vector<std::uint32_t> ids;
  for (std::uint32_t id = 1; ids.size() < count; ++id)
    if (references[id] == 0) ids.push_back(id);
  return ids;
}

namespace {

/// The smallest part of the span with all tiles that the table names.
TileSpan named_part(const TileSpan& span, const std::uint32_t* table) {
  std::int32_t i0 = span.width, i1 = 0, j0 = span.height, j1 = 0;
  for (std::int32_t j = 0, k = 0; j < span.height; ++j)
    for (std::int32_t i = 0; i < span.width; ++i, ++k) {
      if (table[k] == kNoTile) continue;
      i0 = std::min(i0, i), i1 = std::max(i1, i + 1), j0 = std::min(j0, j), j1 = j + 1;
    }
  return j1 == 0 ? TileSpan{} : TileSpan{span.first_i + i0, span.first_j + j0, i1 - i0, j1 - j0};
}

}  // namespace

SlamCells gather_cells(const TileSpan& span, const std::uint32_t* table,
                       const std::function<void(const std::vector<std::uint32_t>& ids, Tile* to)>& read) {
  const TileSpan part = named_part(span, table);
  SlamCells out;
  out.span = span;
  out.first_i = part.first_i * kTileCells, out.first_j = part.first_j * kTileCells;
  out.width = part.width * kTileCells, out.height = part.height * kTileCells;
  out.cell.assign(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height), 0);
  const auto width = static_cast<std::size_t>(part.width);
  std::vector<std::uint32_t> ids;
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < part.size(); ++k) {
    const std::uint32_t id =
        table[span.place(out.first_i + static_cast<std::int32_t>(k % width) * kTileCells,
                         out.first_j + static_cast<std::int32_t>(k / width) * kTileCells)];
    if (id != kNoTile) ids.push_back(id), places.push_back(k);
  }
  std::vector<Tile> tiles(ids.size());
  read(ids, tiles.data());
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    const std::size_t i = places[k] % width, j = places[k] / width;
    const std::size_t first = j * kTileCells * width * kTileCells + i * kTileCells;
    for (std::size_t row = 0; row < kTileCells; ++row)
      std::copy_n(tiles[k].cell + row * kTileCells, kTileCells,
                  out.cell.data() + first + row * width * kTileCells);
  }
  return out;
}

std::unique_ptr<SlamBackend> make_slam_backend(BackendChoice choice, const SlamBackendConfig& config,
                                               std::string& why) {
  if (takes_cuda(choice, why)) {
    if constexpr (PARLOC_WITH_CUDA != 0) return make_cuda_slam_backend(config);
  }
  return make_cpu_slam_backend(config);
}

}  // namespace parloc
