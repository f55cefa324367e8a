#include "tools/report/map_drawing.h"

#include <algorithm>
#include <string>
#include <vector>

#include "tools/report/pictures/picture_style.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {

void draw_cells(Canvas& canvas, const GridMap& map, const MapView& view, Rgba occupied) {
  const std::vector<Cell> cells = raster(map, view);
  std::size_t at = 0;
  for (std::int32_t y = 0; y < view.height_px; ++y) {
    for (std::int32_t x = 0; x < view.width_px; ++x) {
      const Cell cell = cells[at++];
      canvas.set(x, y, cell == Cell::occupied ? occupied : cell == Cell::free ? white : unknown_colour);
    }
  }
}

void draw_scale_bar(Canvas& canvas, const MapView& view) {
  const double length_m = scale_bar_m(view);
  const double length_px = length_m / view.pixel_m();
  const std::string label = number_text(length_m, 4) + " m";
  const std::int32_t text_px = Canvas::text_width(label, text_scale);
  const double wide = std::max<double>(length_px, text_px);
  const double left = margin_px, bottom = view.height_px - margin_px;
  canvas.rectangle(left - 8, bottom - 32, left + wide + 8, bottom + 8, {255, 255, 255, 220});
  canvas.rectangle(left, bottom - 4, left + length_px, bottom, ink);
  canvas.text(
      static_cast<std::int32_t>(left + (length_px - text_px) / 2 + std::max(0.0, (text_px - length_px) / 2)),
      static_cast<std::int32_t>(bottom) - 26, label, text_scale, ink);
}

}  // namespace parloc::tools
