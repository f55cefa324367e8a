// What a global search is asked for, on the lattice of its map.
#pragma once

#include <string>

#include "common/math/pose.h"
#include "common/search/lattice.h"
#include "common/search/search_config.h"
#include "common/search/search_map.h"
#include "common/search/search_scan.h"

namespace parloc {

/// The task without what is in the backend's memory. `scan` has its beams and the number of its headings.
/// Looks at the map no farther than the prior reaches. Throws Error{input} for a prior that is not finite or
/// leaves no free cell; `name` is the map's.
SearchTask make_search_task(const SearchMap& map, const Pose& T_map_grid, const std::string& name,
                            const SearchConfig& config, const SearchScan& scan, const SearchPrior& prior);

}  // namespace parloc
