// What a person would want to know about a map before a robot trusts it (docs/maps.md lists all of it).
#pragma once

#include <string>
#include <vector>

#include "common/map/grid_map.h"
#include "common/map/map_reader.h"

namespace parloc {

/// What the image and the YAML file say that does not fit together: greys that were meant to be unknown and
/// are not, a mode or thresholds for another kind of image, more walls than room, transparency. One line with
/// a number each; empty for a sound map.
std::vector<std::string> image_findings(const ImageMap& read);

/// What is odd about the cells: thin walls with gaps, a resolution that rooms and walls speak against, a
/// border of unknown that costs memory. One line with a number each; empty for a sound map. Time is linear in
/// the cells, memory a byte and 4 per cell.
std::vector<std::string> grid_findings(const GridMap& map);

}  // namespace parloc
