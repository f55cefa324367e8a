// Maps as pictures; those of a run are in report.h.
#pragma once

#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/map/grid_map.h"
#include "common/search/global_search.h"

namespace parloc::tools {

/// One PNG of at most 2000 pixels a side: the cells and, over paler cells, the walls if the map has any, with
/// their ends while these are few; a scale bar. Written to a temporary file that is renamed. Throws
/// Error{output}.
void write_map_picture(const std::string& path, const GridMap& map);

/// One PNG: every hypothesis as a numbered disc with its heading, the first ones in strong colours as long as
/// they are as good as the first; where the scan's beams end (`ends`, base frame) if it was taken at the
/// first. Written to a temporary file that is renamed. Throws Error{output}.
void write_hypothesis_picture(const std::string& path, const GridMap& map,
                              const std::vector<Hypothesis>& hypotheses, const std::vector<EndPoint>& ends);

}  // namespace parloc::tools
