// Openings of a map, and a world in which some are closed and others broken through walls.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "common/math/philox.h"
#include "common/simulator/changed_world.h"

namespace parloc {
namespace {

constexpr double kLeastDoor_m = 0.6, kMostDoor_m = 1.4, kThickestWall_m = 0.35, kLeastWall_m = 0.3;
constexpr double kNewDoor_m = 0.9, kThickestBroken_m = 0.4, kFreeBeside_m = 0.6;
constexpr std::uint32_t kClose = 2, kOpen = 3;  // third word of the counter: who draws

/// A map as seen along its rows, or along its columns: (u, v) is (i, j) or (j, i).
struct Turned {
  const GridMap& map;
  bool by_columns;
  std::int32_t width() const { return by_columns ? map.height : map.width; }
  std::int32_t height() const { return by_columns ? map.width : map.height; }
  Cell at(std::int32_t u, std::int32_t v) const { return by_columns ? map.at(v, u) : map.at(u, v); }
  std::size_t index(std::int32_t u, std::int32_t v) const {
    const std::int32_t i = by_columns ? v : u, j = by_columns ? u : v;
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(i);
  }
  std::int32_t cells(double length_m) const {
    return static_cast<std::int32_t>(std::lround(length_m / map.resolution_m));
  }
};

/// Free cells [from, to) of a row, with occupied ones at both ends.
struct Gap {
  std::int32_t from, to;
};

/// Whether the wall goes on beside the gap, along the row.
bool between_walls(const Turned& map, const Gap& gap, std::int32_t v) {
  for (std::int32_t k = 1; k <= map.cells(kLeastWall_m); ++k)
    if (map.at(gap.from - k, v) != Cell::occupied || map.at(gap.to - 1 + k, v) != Cell::occupied)
      return false;
  return true;
}

std::vector<Gap> gaps_of_row(const Turned& map, std::int32_t v) {
  const std::int32_t least = map.cells(kLeastDoor_m), most = map.cells(kMostDoor_m);
  std::vector<Gap> gaps;
  std::int32_t free_from = 0;  // of the free cells just before
  for (std::int32_t u = 0; u <= map.width(); ++u) {
    if (map.at(u, v) == Cell::free) continue;
    const Gap gap{free_from, u};
    free_from = u + 1;
    const std::int32_t wide = gap.to - gap.from;
    if (wide >= least && wide <= most && between_walls(map, gap, v)) gaps.push_back(gap);
  }
  return gaps;
}

/// Gaps of one row after the other that lie beside each other.
struct Passage {
  std::int32_t first_row;
  std::vector<Gap> gaps;
};

/// Whether one gets through: free before and behind the middle of its ends.
bool leads_through(const Turned& map, const Passage& p) {
  const auto middle = [](const Gap& gap) { return (gap.from + gap.to) / 2; };
  const std::int32_t last_row = p.first_row + static_cast<std::int32_t>(p.gaps.size()) - 1;
  return map.at(middle(p.gaps.front()), p.first_row - 1) == Cell::free &&
         map.at(middle(p.gaps.back()), last_row + 1) == Cell::free;
}

void add_openings(const Turned& map, std::vector<Opening>& openings) {
  std::vector<Passage> open;
  const auto end = [&](const Passage& p) {
    if (static_cast<std::int32_t>(p.gaps.size()) > map.cells(kThickestWall_m) || !leads_through(map, p))
      return;
    Opening opening;
    for (std::size_t k = 0; k < p.gaps.size(); ++k)
      for (std::int32_t u = p.gaps[k].from; u < p.gaps[k].to; ++u)
        opening.cells.push_back(map.index(u, p.first_row + static_cast<std::int32_t>(k)));
    openings.push_back(std::move(opening));
  };
  for (std::int32_t v = 0; v <= map.height(); ++v) {
    std::vector<Passage> still_open;
    std::vector<Gap> gaps = v < map.height() ? gaps_of_row(map, v) : std::vector<Gap>{};
    for (Passage& p : open) {
      const Gap last = p.gaps.back();
      const auto beside = std::find_if(gaps.begin(), gaps.end(), [&](const Gap& g) {
        return 2 * (std::min(g.to, last.to) - std::max(g.from, last.from)) > last.to - last.from;
      });
      if (beside == gaps.end()) {
        end(p);
      } else {
        p.gaps.push_back(*beside);
        gaps.erase(beside);
        still_open.push_back(std::move(p));
      }
    }
    for (const Gap& gap : gaps) still_open.push_back({v, {gap}});
    open = std::move(still_open);
  }
}

/// The wall's cells of a new door through the occupied cell (u, v), along the row; none if it is not a thin
/// wall between free cells.
std::vector<std::size_t> broken_through(const Turned& map, std::int32_t u, std::int32_t v) {
  std::vector<std::size_t> cells;
  const std::int32_t beside = map.cells(kFreeBeside_m);
  for (std::int32_t row = v; row < v + map.cells(kNewDoor_m); ++row) {
    if (map.at(u, row) != Cell::occupied) return {};
    std::int32_t from = u, to = u;
    while (map.at(from - 1, row) == Cell::occupied) --from;
    while (map.at(to + 1, row) == Cell::occupied) ++to;
    if (to - from + 1 > map.cells(kThickestBroken_m)) return {};
    for (std::int32_t k = 1; k <= beside; ++k)
      if (map.at(from - k, row) != Cell::free || map.at(to + k, row) != Cell::free) return {};
    for (std::int32_t k = from; k <= to; ++k) cells.push_back(map.index(k, row));
  }
  return cells;
}

std::vector<std::size_t> break_doors(const GridMap& map, std::size_t wanted, std::uint64_t seed) {
  constexpr std::uint32_t kTriesPerDoor = 5000;
  std::vector<std::size_t> occupied, broken;
  for (std::size_t k = 0; k < map.size(); ++k)
    if (map.cells[k] == Cell::occupied) occupied.push_back(k);
  if (occupied.empty()) return broken;
  std::size_t doors = 0;
  for (std::uint32_t k = 0; doors < wanted && k < kTriesPerDoor * wanted; ++k) {
    const Philox4x32 r = philox(k, 0u, Stream::changed_world, kOpen, seed);
    const std::size_t cell = occupied[uniform_below(r.w[0], static_cast<std::uint32_t>(occupied.size()))];
    const auto i = static_cast<std::int32_t>(cell % static_cast<std::size_t>(map.width));
    const auto j = static_cast<std::int32_t>(cell / static_cast<std::size_t>(map.width));
    const bool by_columns = uniform_below(r.w[1], 2) == 1;
    const std::vector<std::size_t> door =
        broken_through({map, by_columns}, by_columns ? j : i, by_columns ? i : j);
    broken.insert(broken.end(), door.begin(), door.end());
    doors += door.empty() ? 0 : 1;
  }
  std::sort(broken.begin(), broken.end());
  broken.erase(std::unique(broken.begin(), broken.end()), broken.end());
  return broken;
}

}  // namespace

std::vector<Opening> find_openings(const GridMap& map) {
  std::vector<Opening> openings;
  for (const bool by_columns : {false, true}) add_openings({map, by_columns}, openings);
  return openings;
}

WorldChange change_doors(const GridMap& map, const WaypointPath& path, double clearance_m, double share,
                         std::uint64_t seed) {
  WorldChange change;
  const std::vector<std::uint8_t> kept_free = cells_near_path(map, path, clearance_m);
  std::vector<Opening> openings = find_openings(map);
  const auto wanted = static_cast<std::size_t>(std::lround(share * static_cast<double>(openings.size())));
  std::size_t closed = 0;
  for (std::uint32_t k = 0; closed < wanted && !openings.empty(); ++k) {
    const std::size_t which = uniform_below(philox(k, 0u, Stream::changed_world, kClose, seed).w[0],
                                            static_cast<std::uint32_t>(openings.size()));
    std::swap(openings[which], openings.back());
    const std::vector<std::size_t> cells = std::move(openings.back().cells);
    openings.pop_back();
    if (std::any_of(cells.begin(), cells.end(), [&](std::size_t c) { return kept_free[c] != 0; })) continue;
    change.added.insert(change.added.end(), cells.begin(), cells.end());
    ++closed;
  }
  std::sort(change.added.begin(), change.added.end());
  change.added.erase(std::unique(change.added.begin(), change.added.end()), change.added.end());
  change.removed = break_doors(map, wanted, seed);
  return change;
}

}  // namespace parloc
