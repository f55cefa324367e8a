// What every picture of a map has.
#pragma once

#include "common/map/grid_map.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"

namespace parloc::tools {

/// The cells, occupied ones in `occupied`. The canvas has the size of the view.
void draw_cells(Canvas& canvas, const GridMap& map, const MapView& view, Rgba occupied);

/// In the lower left corner of the map, on a pale plate so that it can be read on walls.
void draw_scale_bar(Canvas& canvas, const MapView& view);

}  // namespace parloc::tools
