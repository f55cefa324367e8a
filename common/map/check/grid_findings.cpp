#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/map/check/known_part.h"
#include "common/map/check/map_findings.h"

namespace parloc {
namespace {

/// A line of cells of a map, along x or along y.
struct Line {
  std::size_t first, step, count;
  std::size_t cell(std::size_t k) const { return first + k * step; }
};

template <class Take>
void for_each_line(const GridMap& map, const Take& take) {
  const auto width = static_cast<std::size_t>(map.width), height = static_cast<std::size_t>(map.height);
  for (std::size_t j = 0; j < height; ++j) take(Line{j * width, 1, width});
  for (std::size_t i = 0; i < width; ++i) take(Line{i, width, height});
}

/// Calls take(begin, end) for every run of cells of the kind in a line.
template <class Take>
void for_each_run(const GridMap& map, const Line& line, Cell kind, const Take& take) {
  for (std::size_t k = 0; k < line.count; ++k) {
    if (map.cells[line.cell(k)] != kind) continue;
    std::size_t end = k + 1;
    while (end < line.count && map.cells[line.cell(end)] == kind) ++end;
    take(k, end);
    k = end;
  }
}

/// How wide the place is that each cell of the kind lies in: the shorter of its runs along x and y [cells].
/// 0 for other cells.
std::vector<std::uint16_t> widths(const GridMap& map, Cell kind) {
  std::vector<std::uint16_t> shortest(map.size());
  for_each_line(map, [&](const Line& line) {
    for_each_run(map, line, kind, [&](std::size_t begin, std::size_t end) {
      const auto length = static_cast<std::uint16_t>(end - begin);  // a side is at most 32767
      for (std::size_t k = begin; k < end; ++k) {
        std::uint16_t& of_cell = shortest[line.cell(k)];
        of_cell = of_cell == 0 ? length : std::min(of_cell, length);
      }
    });
  });
  return shortest;
}

/// That most cells of the kind are in places as wide as this, or less [cells]; 0 without such cells.
double median_width(const std::vector<std::uint16_t>& widths) {
  std::vector<std::size_t> counts(32768);
  std::size_t all = 0;
  for (const std::uint16_t width : widths)
    if (width > 0) ++counts[width], ++all;
  std::size_t below = 0, width = 0;
  while (2 * below < all) below += counts[++width];
  return static_cast<double>(width);
}

constexpr double kWidestGap_m = 0.3;    ///< A door is wider.
constexpr std::size_t kLongestGap = 3;  ///< [cells]

struct ThinWalls {
  std::size_t cells = 0, gaps = 0;
};

/// Gaps of a few cells in straight walls that are one cell thin, with two cells of it on either side.
class GapCounter {
 public:
  explicit GapCounter(const GridMap& map)
      : map_(map),
        longest_(std::min(kLongestGap, static_cast<std::size_t>(kWidestGap_m / map.resolution_m + 1e-9))) {}

  ThinWalls count() {
    ThinWalls walls;
    for_each_line(map_, [&](const Line& line) {
      std::size_t last = 0;  // where the thin piece before ends; 0: there is none
      for_each_run(map_, line, Cell::occupied, [&](std::size_t begin, std::size_t end) {
        const bool is_thin = end - begin >= 2 && alone(line, begin, end);
        if (is_thin) walls.cells += end - begin;
        if (is_thin && last > 0 && begin - last <= longest_ && is_gap(line, last, begin)) ++walls.gaps;
        last = is_thin ? end : 0;
      });
    });
    return walls;
  }

 private:
  /// Whether a cell on either side of the k-th of a line is occupied.
  bool has_neighbour(const Line& line, std::size_t k) const {
    const auto width = static_cast<std::size_t>(map_.width);
    const auto i = static_cast<std::int32_t>(line.cell(k) % width);
    const auto j = static_cast<std::int32_t>(line.cell(k) / width);
    const auto is_occupied = [&](std::int32_t by) {
      return (line.step == 1 ? map_.at(i, j + by) : map_.at(i + by, j)) == Cell::occupied;
    };
    return is_occupied(-1) || is_occupied(1);
  }
  /// That no cell beside a piece of a line is occupied, its ends apart (a corner).
  bool alone(const Line& line, std::size_t begin, std::size_t end) const {
    std::size_t beside = 0;
    for (std::size_t k = begin; k < end; ++k) beside += has_neighbour(line, k) ? 1 : 0;
    return 4 * beside <= end - begin || (beside <= 1 && end - begin >= 3);
  }
  /// That what is between is free, and nothing closes it beside.
  bool is_gap(const Line& line, std::size_t begin, std::size_t end) const {
    for (std::size_t k = begin; k < end; ++k)
      if (map_.cells[line.cell(k)] != Cell::free) return false;
    for (std::size_t k = begin - 1; k <= end; ++k)
      if (has_neighbour(line, k)) return false;
    return true;
  }

  const GridMap& map_;
  std::size_t longest_;  ///< [cells]
};

void find_gaps(const GridMap& map, std::vector<std::string>& findings) {
  const ThinWalls walls = GapCounter(map).count();
  // Maps of robots have up to one gap in 100 cells of thin wall.
  if (walls.gaps < 4 || 33 * walls.gaps < walls.cells) return;
  const double length_m = static_cast<double>(walls.cells) * map.resolution_m;
  findings.push_back(
      fmt::format("walls one cell thin have {} gaps of 1 to {} cells, one in every {:.2f} m: "
                  "rays pass through; draw them closed",
                  walls.gaps, kLongestGap, length_m / static_cast<double>(walls.gaps)));
}

// Where people and robots drive, half of the free cells are in places of 1.9 to 10 m between walls, in a hall
// 30 m; walls are 0.01 to 0.25 m thick.
void find_unlikely_resolution(const GridMap& map, std::vector<std::string>& findings) {
  const auto count = [&](Cell kind) { return std::count(map.cells.begin(), map.cells.end(), kind); };
  if (count(Cell::occupied) > count(Cell::free)) return;  // these are no walls
  const double walls_m = median_width(widths(map, Cell::occupied)) * map.resolution_m;
  const double room_m = median_width(widths(map, Cell::free)) * map.resolution_m;
  if (walls_m == 0.0 || room_m == 0.0) return;
  const bool coarse = room_m > 60.0 || (room_m > 12.0 && walls_m >= 0.4);
  const bool fine = room_m < 0.5 || (room_m < 1.5 && walls_m < 0.03);
  if (!coarse && !fine) return;
  findings.push_back(fmt::format(
      "a resolution of {} m is unlikely: it makes the typical place {:.3g} m wide and walls {:.3g} m thick; "
      "with {} m it would be {:.3g} m and {:.3g} m",
      map.resolution_m, room_m, walls_m, coarse ? map.resolution_m / 10.0 : map.resolution_m * 10.0,
      coarse ? room_m / 10.0 : room_m * 10.0, coarse ? walls_m / 10.0 : walls_m * 10.0));
}

/// What a map takes: its cells, the likelihood field and the leaps of rays [bytes].
double memory_bytes(std::size_t cells) {
  constexpr std::size_t most_with_all_leaps = 4'000'000;
  return static_cast<double>(cells) * (cells <= most_with_all_leaps ? 1.0 + 4.0 + 33.0 : 1.0 + 4.0 + 1.0);
}

void find_border(const GridMap& map, std::vector<std::string>& findings) {
  const CellBox known = known_part(map);
  const double saved_MB = (memory_bytes(map.size()) - memory_bytes(known.size())) / 1e6;
  const double share = 1.0 - static_cast<double>(known.size()) / static_cast<double>(map.size());
  if (share < 0.4 || saved_MB < 2.0) return;
  findings.push_back(fmt::format(
      "a border of unknown is {:.0f} % of the cells and takes about {:.0f} MB of memory: parloc map "
      "convert --crop leaves {} x {} cells",
      100.0 * share, saved_MB, known.width, known.height));
}

}  // namespace

std::vector<std::string> grid_findings(const GridMap& map) {
  std::vector<std::string> findings;
  find_gaps(map, findings);
  find_unlikely_resolution(map, findings);
  find_border(map, findings);
  return findings;
}

}  // namespace parloc
