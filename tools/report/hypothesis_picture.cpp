#include "tools/report/hypothesis_picture.h"

#include <cmath>
#include <optional>

#include "common/error.h"
#include "common/file/output_file.h"
#include "tools/report/map_drawing.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/picture_style.h"
#include "tools/report/pictures/png_writer.h"
#include "tools/report/report.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t least_px = 1100, most_px = 2000;
constexpr Rgba pale_ink = {130, 136, 144, 255};

void draw_scan(Canvas& canvas, const MapView& view, const Pose& pose, const std::vector<EndPoint>& ends) {
  for (const EndPoint& end : ends) {
    const Pose p = compose(pose, {end.x_m, end.y_m, 0.0});
    if (!drawable_point(p.x_m, p.y_m)) continue;
    const Pixel at = view.to_pixel(p.x_m, p.y_m);
    canvas.disc(at.x, at.y, 3.5, truth_colour);
  }
}

void draw_hypothesis(Canvas& canvas, const MapView& view, const Hypothesis& h, std::size_t number) {
  const Rgba colour = !h.as_good ? pale_ink : number == 1 ? estimate_colour : odometry_colour;
  const Pixel at = view.to_pixel(h.pose.x_m, h.pose.y_m);
  const double angle = view.to_image_angle(h.pose.theta_rad), length_px = 30;
  const double tip_x = at.x + length_px * std::cos(angle), tip_y = at.y - length_px * std::sin(angle);
  canvas.line(at.x, at.y, tip_x, tip_y, 9, white);
  canvas.line(at.x, at.y, tip_x, tip_y, 5, colour);
  canvas.disc(at.x, at.y, 15, white);
  canvas.disc(at.x, at.y, 13, colour);
  const std::string label = std::to_string(number);
  const std::int32_t wide = Canvas::text_width(label, text_scale);
  canvas.text(static_cast<std::int32_t>(at.x) - wide / 2, static_cast<std::int32_t>(at.y) - 7, label,
              text_scale, white);
}

}  // namespace

void write_hypothesis_picture(const std::string& path, const GridMap& map,
                              const std::vector<Hypothesis>& hypotheses, const std::vector<EndPoint>& ends) {
  RunReport report;
  report.map = &map;
  const std::optional<MapView> view = fit_view(report, least_px, most_px);
  if (!view) throw Error(ErrorKind::output, path + ": cannot be written: the map has nothing to show");
  Canvas canvas(view->width_px, view->height_px, white);
  draw_cells(canvas, map, *view, ink);
  if (!hypotheses.empty()) draw_scan(canvas, *view, hypotheses.front().pose, ends);
  for (std::size_t n = hypotheses.size(); n-- > 0;)  // the best on top
    draw_hypothesis(canvas, *view, hypotheses[n], n + 1);
  draw_scale_bar(canvas, *view);
  replace_file(path, encode_png_rgb(view->width_px, view->height_px, canvas.pixels()));
}

}  // namespace parloc::tools
