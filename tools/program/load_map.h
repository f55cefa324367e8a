// A map of any kind, with what only its file knows.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "common/map/grid_map.h"

namespace parloc::tools {

/// What a segment file held besides the walls that are used.
struct SegmentFacts {
  std::string title;  ///< May be empty.
  std::size_t zero_length = 0, duplicates = 0;
  bool enclosed = false;
};

struct LoadedMap {
  GridMap map;
  std::optional<SegmentFacts> segments;  ///< Of a segment map.
};

/// As read_map(); `resolution_m` replaces that of a segment map and has no effect on others.
LoadedMap load_map(const std::string& path, std::optional<double> resolution_m = {});

double total_length_m(const GridMap& map);

/// "2 of zero length, 1 duplicate"; empty if nothing was left out.
std::string left_out(const SegmentFacts& facts);

}  // namespace parloc::tools
