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
  std::vector<Offset> offsets;          ///< [headings][beams], or more; of the headings turned to.

  double heading_rad(std::int32_t k) const;
};

/// Takes config.beams of the hits, evenly over the table, in an order of which the first few look all around.
/// map_resolution_m: what the table's end points are counted in. No offsets yet, but room for them.
/// Deterministic on every machine.
void choose_search_beams(const BeamTable& table, double map_resolution_m, double cell_m,
                         const SearchConfig& config, SearchScan& scan);
/// The offsets of heading k.
void turn_search_scan(SearchScan& scan, double cell_m, std::int32_t k);
/// Both, for every heading.
void make_search_scan(const BeamTable& table, double map_resolution_m, double cell_m,
                      const SearchConfig& config, SearchScan& scan);

}  // namespace parloc
