#include "tools/report/map_drawing.h"

#include <algorithm>
#include <string>
#include <vector>

#include "tools/report/pictures/picture_style.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {

void draw_cells(Canvas& canvas, const GridMap& map, const MapView& view, Rgba occupied) {
  const std::vector<Cell> cells = raster(map, view);
  std::size_t next = 0;
  canvas.paint(view.width_px, view.height_px, [&](std::int32_t, std::int32_t) {
    const Cell cell = cells[next++];
    return cell == Cell::occupied ? occupied : cell == Cell::free ? white : unknown_colour;
  });
}

void draw_scale_bar(Canvas& canvas, const MapView& view) {
  const double length_m = scale_bar_m(view);
  const double length_px = length_m / view.pixel_m();
  const std::string label = number_text(length_m, 4) + " m";
  const double wide = std::max(length_px, canvas.text_width(label));
  const double left = margin_px, bottom = view.height_px - margin_px;
  canvas.rectangle(left - 8, bottom - 32, left + wide + 8, bottom + 8, {255, 255, 255, 220});
  canvas.rectangle(left, bottom - 4, left + length_px, bottom, ink);
  canvas.text({left + wide / 2, bottom - 18}, label, ink, Anchor::middle);
}

}  // namespace parloc::tools
