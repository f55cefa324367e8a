#include "tools/report/hypothesis_picture.h"

#include <cmath>

#include "common/file/output_file.h"
#include "tools/report/map_drawing.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/picture_style.h"
#include "tools/report/report.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t least_px = 1100, most_px = 2000;
constexpr Rgba pale_ink = {130, 136, 144, 255};

void draw_scan(Canvas& canvas, const MapView& view, const Pose& pose, const std::vector<EndPoint>& ends) {
  for (const EndPoint& end : ends) {
    const Pose p = compose(pose, {end.x_m, end.y_m, 0.0});
    if (!drawable_point(p.x_m, p.y_m)) continue;
    canvas.disc(view.to_pixel(p.x_m, p.y_m), 3.5, truth_colour);
  }
}

void draw_hypothesis(Canvas& canvas, const MapView& view, const Hypothesis& h, std::size_t number) {
  const Rgba colour = !h.as_good ? pale_ink : number == 1 ? estimate_colour : odometry_colour;
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
