// A map with the places where a scan may have been taken.
#pragma once

#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/map/grid_map.h"
#include "common/search/global_search.h"

namespace parloc::tools {

/// One PNG: every hypothesis as a numbered disc with its heading, the first ones in strong colours as long as
/// they are as good as the first; where the scan's beams end (`ends`, base frame) if it was taken at the
/// first. Written to a temporary file that is renamed. Throws Error{output}.
void write_hypothesis_picture(const std::string& path, const GridMap& map,
                              const std::vector<Hypothesis>& hypotheses, const std::vector<EndPoint>& ends);

}  // namespace parloc::tools
