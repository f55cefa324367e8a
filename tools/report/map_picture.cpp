#include "tools/report/map_picture.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/file/output_file.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/pixel.h"
#include "tools/report/report.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t least_px = 1100, most_px = 2000;
constexpr Rgba pale_walls = {182, 188, 196, 255}, pale_discs = {130, 136, 144, 255};
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

void draw_scan(Canvas& canvas, const MapView& view, const Pose& pose, const std::vector<EndPoint>& ends) {
  for (const EndPoint& end : ends) {
    const Pose p = compose(pose, {end.x_m, end.y_m, 0.0});
    if (!drawable_point(p.x_m, p.y_m)) continue;
    canvas.disc(view.to_pixel(p.x_m, p.y_m), 3.5, truth_colour);
  }
}

void draw_hypothesis(Canvas& canvas, const MapView& view, const Hypothesis& h, std::size_t number) {
  const Rgba colour = !h.as_good ? pale_discs : number == 1 ? estimate_colour : odometry_colour;
  const Pixel at = view.to_pixel(h.pose.x_m, h.pose.y_m);
  const double angle = view.to_image_angle(h.pose.theta_rad), length_px = 30;
  const Pixel tip = {at.x + length_px * std::cos(angle), at.y - length_px * std::sin(angle)};
  canvas.line({at, tip}, 9, white);
  canvas.line({at, tip}, 5, colour);
  canvas.disc(at, 15, white);
  canvas.disc(at, 13, colour);
  canvas.text(at, std::to_string(number), white, Anchor::middle);
}

}  // namespace

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

void write_map_picture(const std::string& path, const GridMap& map) {
  RunReport report;
  report.map = &map;
  const MapView view = view_to_write(path, report, least_px, most_px);
  Canvas canvas(view.width_px, view.height_px);
  draw_cells(canvas, map, view, map.walls.empty() ? ink : pale_walls);
  draw_walls(canvas, map, view);
  draw_scale_bar(canvas, view);
  replace_file(path, canvas.png());
}

void write_hypothesis_picture(const std::string& path, const GridMap& map,
                              const std::vector<Hypothesis>& hypotheses, const std::vector<EndPoint>& ends) {
  RunReport report;
  report.map = &map;
  const MapView view = view_to_write(path, report, least_px, most_px);
  Canvas canvas(view.width_px, view.height_px);
  draw_cells(canvas, map, view, ink);
  if (!hypotheses.empty()) draw_scan(canvas, view, hypotheses.front().pose, ends);
  for (std::size_t n = hypotheses.size(); n-- > 0;)  // the best on top
    draw_hypothesis(canvas, view, hypotheses[n], n + 1);
  draw_scale_bar(canvas, view);
  replace_file(path, canvas.png());
}

}  // namespace parloc::tools
