// Maps as pictures.
#pragma once

#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/map/grid_map.h"
#include "common/search/global_search.h"
#include "tools/report/map_view.h"

namespace parloc::tools {

class Canvas;  // Cairo is known to those who draw

/// The cells, occupied ones in `occupied`. The canvas has the size of the view.
void draw_cells(Canvas& canvas, const GridMap& map, const MapView& view, Rgba occupied);

/// In the lower left corner of the map, on a pale plate so that it can be read on walls.
void draw_scale_bar(Canvas& canvas, const MapView& view);

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
