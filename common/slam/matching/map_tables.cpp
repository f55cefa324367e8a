#include "common/slam/matching/map_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "common/map/map_limits.h"

namespace parloc {

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

}  // namespace parloc
