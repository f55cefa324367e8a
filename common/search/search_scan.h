// A scan made ready for the global search: where each beam's end point lies from a cell, by heading.
#pragma once

#include <cstdint>
#include <vector>

#include "common/model/beams.h"
#include "common/search/lattice.h"
#include "common/search/search_config.h"

namespace parloc {

/// Keeps its capacity.
struct SearchScan {
  std::int32_t beams = 0, headings = 0;
  std::vector<float> end_x_m, end_y_m;  ///< Of the chosen hits, base frame.
  std::vector<Offset> offsets;          ///< [headings][beams]

  double heading_rad(std::int32_t k) const;
};

/// Takes config.beams of the hits, evenly over the table, in an order of which the first few look all around.
/// map_resolution_m: what the table's end points are counted in. Deterministic on every machine.
void make_search_scan(const BeamTable& table, double map_resolution_m, double cell_m,
                      const SearchConfig& config, SearchScan& scan);

}  // namespace parloc
