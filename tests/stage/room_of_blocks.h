// The map on which backends are compared.
#pragma once

#include "common/map/grid_map.h"

namespace parloc::test {

/// Four walls around 5.5 x 3 m, and 14 blocks of one cell inside.
inline std::vector<std::string> rows_with_blocks() {
  std::vector<std::string> rows(60, std::string(110, '.'));
  for (std::size_t i = 0; i < 110; ++i) rows.front()[i] = rows.back()[i] = '#';
  for (auto& r : rows) r.front() = r.back() = '#';
  for (std::size_t k = 0; k < 14; ++k) rows[5 + k * 3][(k * 37) % 100 + 4] = '#';
  return rows;
}
/// With a wall in the middle.
inline std::vector<std::string> rows_with_blocks_and_wall() {
  std::vector<std::string> rows = rows_with_blocks();
  for (std::size_t j = 20; j < 40; ++j) rows[j][55] = '#';
  return rows;
}
/// Neither at the origin nor along the axes.
inline GridMap room_of_blocks(const std::vector<std::string>& rows) {
  return grid_from_text(rows, 0.05, {-1.0, 2.0, 0.3});
}

}  // namespace parloc::test
