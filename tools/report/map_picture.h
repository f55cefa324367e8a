// A map as a picture.
#pragma once

#include <string>

#include "common/map/grid_map.h"

namespace parloc::tools {

/// One PNG of at most 2000 pixels a side: the cells and, over paler cells, the walls if the map has any, with
/// their ends while these are few; a scale bar. Written to a temporary file that is renamed. Throws
/// Error{output}.
void write_map_picture(const std::string& path, const GridMap& map);

}  // namespace parloc::tools
