#include "common/map/check/known_part.h"

#include <algorithm>

#include "common/error.h"
#include "common/math/pose.h"

namespace parloc {

CellBox known_part(const GridMap& map) {
  std::int32_t left = map.width, right = -1, bottom = map.height, top = -1;
  for (std::int32_t j = 0; j < map.height; ++j) {
    const auto row = map.cells.begin() + static_cast<std::ptrdiff_t>(map.index(0, j)), end = row + map.width;
    const auto is_known = [](Cell cell) { return cell != Cell::unknown; };
    const auto first = std::find_if(row, end, is_known);
    if (first == end) continue;
    std::int32_t last = map.width - 1;
    while (!is_known(row[last])) --last;
    left = std::min(left, static_cast<std::int32_t>(first - row));
    right = std::max(right, last);
    bottom = std::min(bottom, j);
    top = j;
  }
  return top < 0 ? CellBox{} : CellBox{left, bottom, right - left + 1, top - bottom + 1};
}

GridMap cropped(const GridMap& map, std::int32_t margin) {
  const CellBox known = known_part(map);
  if (known.size() == 0) throw input_error(map.name, 0, "expected a known cell to crop to, found none");
  const std::int32_t left = std::max(known.i - margin, 0), bottom = std::max(known.j - margin, 0);
  GridMap part;
  part.width = std::min(known.i + known.width + margin, map.width) - left;
  part.height = std::min(known.j + known.height + margin, map.height) - bottom;
  part.resolution_m = map.resolution_m;
  part.T_map_grid = compose(map.T_map_grid, {left * map.resolution_m, bottom * map.resolution_m, 0.0});
  part.name = map.name;
  part.notes = map.notes;
  part.cells.reserve(static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height));
  for (std::int32_t j = bottom; j < bottom + part.height; ++j) {
    const auto row = map.cells.begin() + static_cast<std::ptrdiff_t>(map.index(left, j));
    part.cells.insert(part.cells.end(), row, row + part.width);
  }
  return part;
}

}  // namespace parloc
