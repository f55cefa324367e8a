#include "tools/report/map_picture.h"

#include "common/file/output_file.h"
#include "tools/report/map_drawing.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/picture_style.h"
#include "tools/report/report.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t least_px = 1100, most_px = 2000;
constexpr Rgba pale_ink = {182, 188, 196, 255};
constexpr std::size_t most_ends = 500;  // more would hide the walls

void draw_walls(Canvas& canvas, const GridMap& map, const MapView& view) {
  const auto pixel = [&](float x_m, float y_m) {
    const Pose p = compose(map.T_map_grid, {x_m, y_m, 0.0});
    return view.to_pixel(p.x_m, p.y_m);
  };
  const bool with_ends = map.walls.size() <= most_ends;
  for (const GridWall& wall : map.walls) {
    const Pixel a = pixel(wall.ax, wall.ay), b = pixel(wall.bx, wall.by);
    canvas.line({a, b}, 2.5, estimate_colour);
    if (!with_ends) continue;
    canvas.disc(a, 3.5, truth_colour);
    canvas.disc(b, 3.5, truth_colour);
  }
}

}  // namespace

void write_map_picture(const std::string& path, const GridMap& map) {
  RunReport report;
  report.map = &map;
  const MapView view = view_to_write(path, report, least_px, most_px);
  Canvas canvas(view.width_px, view.height_px);
  draw_cells(canvas, map, view, map.walls.empty() ? ink : pale_ink);
  draw_walls(canvas, map, view);
  draw_scale_bar(canvas, view);
  replace_file(path, canvas.png());
}

}  // namespace parloc::tools
