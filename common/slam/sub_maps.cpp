#include "common/slam/sub_maps.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"
#include "common/slam/checkpoint_values.h"

namespace parloc {
namespace {

/// Beyond the reach of a scan so many tiles stay, so that a place is not handed over and back all the time.
constexpr int kKeptTiles = 3;
constexpr double kMiB = 1024.0 * 1024.0;

bool contains(const TileSpan& span, std::int32_t i, std::int32_t j) {
  return i >= span.first_i && j >= span.first_j && i < span.first_i + span.width &&
         j < span.first_j + span.height;
}

/// What two maps know of the same place. Neither field runs over: both are aged.
void add(Tile& to, const Tile& from) {
  for (std::int32_t k = 0; k < kTileCells * kTileCells; ++k) to.cell[k] = aged(to.cell[k] + from.cell[k]);
  set_occupied(to);
}

/// The same cells in the smallest rectangle that holds these places as well.
SlamCells grown_cells(const SlamCells& cells,
                      const std::map<std::pair<std::int32_t, std::int32_t>, Tile>& places) {
  const auto& first = places.begin()->first;
  const bool none = cells.width == 0;
  std::int32_t i0 = none ? first.first * kTileCells : cells.first_i, i1 = i0 + cells.width;
  std::int32_t j0 = none ? first.second * kTileCells : cells.first_j, j1 = j0 + cells.height;
  for (const auto& [place, tile] : places) {
    i0 = std::min(i0, place.first * kTileCells), i1 = std::max(i1, (place.first + 1) * kTileCells);
    j0 = std::min(j0, place.second * kTileCells), j1 = std::max(j1, (place.second + 1) * kTileCells);
  }
  SlamCells out = cells;
  out.first_i = i0, out.first_j = j0, out.width = i1 - i0, out.height = j1 - j0;
  const auto width = static_cast<std::size_t>(out.width), old_width = static_cast<std::size_t>(cells.width);
  out.cell.assign(width * static_cast<std::size_t>(out.height), 0);
  for (std::size_t j = 0; j < static_cast<std::size_t>(cells.height); ++j)
    std::copy_n(cells.cell.data() + j * old_width, old_width,
                out.cell.data() + (j + static_cast<std::size_t>(cells.first_j - j0)) * width +
                    static_cast<std::size_t>(cells.first_i - i0));
  return out;
}

std::vector<Tile> read(const SlamBackend& backend, const std::vector<std::uint32_t>& ids) {
  std::vector<Tile> tiles(ids.size());
  backend.read_tiles(ids, tiles.data());
  return tiles;
}

}  // namespace

SubMaps::SubMaps(const SlamConfig& config)
    : config_(config),
      reach_m_(config.usable_range + config.search_xy),
      most_tiles_(static_cast<std::size_t>(config.memory_mib * kMiB / static_cast<double>(sizeof(Tile)))) {}

void SubMaps::give_back(SlamBackend& backend, double travel_m) {
  if (tile_.empty()) return;
  SlamSnapshot s = backend.save();
  constexpr double kMostTravel =
      2.0;  // times the odometry's; who goes farther sees nothing there, and adds later
  const double reach_m = reach_m_ + kMostTravel * travel_m;
  const TileSpan near = reached_tiles(s.x, s.y, reach_m, config_.resolution);
  std::vector<Place> places;
  for (const auto& [place, tile] : tile_)
    if (contains(near, place.first, place.second) && contains(s.span, place.first, place.second))
      places.push_back(place);
  if (places.empty()) return;
  if (too_many(tiles_named(s.table).size() + 1 + places.size())) hand_over(backend, s, reach_m);
  restore(backend, s, places);
}

void SubMaps::make_room(SlamBackend& backend) {
  if (!too_many(backend.mark())) return;
  SlamSnapshot s = backend.save();
  hand_over(backend, s, reach_m_);
  const std::size_t needed = backend.mark();
  if (!too_many(needed)) return;
  throw Error(
      ErrorKind::config,
      fmt::format("slam.memory_mib is {}, but what is near the robot takes {:.1f} MiB with {} "
                  "particles: expected more memory, fewer particles or a smaller slam.usable_range",
                  config_.memory_mib, static_cast<double>(needed * sizeof(Tile)) / kMiB, config_.particles));
}

void SubMaps::hand_over(SlamBackend& backend, SlamSnapshot& s, double reach_m) {
  const double kept_m = kKeptTiles * kTileCells * config_.resolution;
  const TileSpan near = reached_tiles(s.x, s.y, reach_m + kept_m, config_.resolution);
  const auto best = std::max_element(s.likelihood.begin(), s.likelihood.end()) - s.likelihood.begin();
  std::vector<Place> places;
  std::vector<std::uint32_t> ids;
  const std::size_t size = s.span.size();
  for (std::size_t k = 0; k < size; ++k) {
    const auto width = static_cast<std::size_t>(s.span.width);
    const Place place{s.span.first_i + static_cast<std::int32_t>(k % width),
                      s.span.first_j + static_cast<std::int32_t>(k / width)};
    if (contains(near, place.first, place.second)) continue;
    if (const std::uint32_t id = s.table[static_cast<std::size_t>(best) * size + k]; id != kNoTile) {
      places.push_back(place);
      ids.push_back(id);
    }
    for (std::size_t p = k; p < s.table.size(); p += size) s.table[p] = kNoTile;
  }
  const std::vector<Tile> tiles = read(backend, ids);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto [at, is_new] = tile_.try_emplace(places[k], tiles[k]);
    if (!is_new) add(at->second, tiles[k]);
  }
  backend.load(s);
}

void SubMaps::restore(SlamBackend& backend, SlamSnapshot& s, const std::vector<Place>& places) {
  const std::size_t size = s.span.size();
  std::vector<std::uint32_t> ids = backend.free_tiles(places.size()), own;
  std::vector<Tile> tiles, given;
  for (std::size_t k = 0; k < places.size(); ++k) {
    given.push_back(tile_.at(places[k]));
    const std::size_t at =
        static_cast<std::size_t>(places[k].second - s.span.first_j) * static_cast<std::size_t>(s.span.width) +
        static_cast<std::size_t>(places[k].first - s.span.first_i);
    own.clear();
    for (std::size_t p = at; p < s.table.size(); p += size) {
      if (s.table[p] == kNoTile)
        s.table[p] = ids[k];
      else if (s.table[p] != ids[k])
        own.push_back(s.table[p]);
    }
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    tiles = read(backend, own);
    for (Tile& tile : tiles) add(tile, given.back());
    backend.write_tiles(own, tiles.data());
    tile_.erase(places[k]);
  }
  backend.write_tiles(ids, given.data());
  backend.load(s);
}

void SubMaps::add_to(SlamCells& cells) const {
  if (tile_.empty()) return;
  cells = grown_cells(cells, tile_);
  for (const auto& [place, tile] : tile_) {
    const auto i0 = static_cast<std::size_t>(place.first * kTileCells - cells.first_i),
               j0 = static_cast<std::size_t>(place.second * kTileCells - cells.first_j);
    for (std::size_t j = 0; j < kTileCells; ++j)
      for (std::size_t i = 0; i < kTileCells; ++i) {
        CellWord& cell = cells.cell[(j0 + j) * static_cast<std::size_t>(cells.width) + i0 + i];
        cell = aged(cell + tile.cell[j * kTileCells + i]);
      }
  }
}

void SubMaps::save(ByteWriter& w) const {
  w.put_count(tile_.size());
  for (const auto& [place, tile] : tile_) {
    w.put(place.first), w.put(place.second);
    put_tile(w, tile);
  }
}

void SubMaps::load(ByteReader& r, const TileSpan& span) {
  tile_.clear();
  for (std::size_t left = r.get_count(8 + sizeof(Tile::cell)); left > 0; --left) {
    const auto i = r.get<std::int32_t>(), j = r.get<std::int32_t>();
    r.expect(contains(span, i, j), "places on the map");
    tile_[{i, j}] = get_tile(r);
  }
}

}  // namespace parloc
