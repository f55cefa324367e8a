#include "tools/report/plots/plot.h"

#include <cmath>
#include <optional>

#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/pixel.h"
#include "tools/report/plots/plot_shapes.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t kWidth_px = 1000, kLeft_px = 100, kRight_px = 76;
constexpr Rgba kGrid = {216, 221, 227, 255}, kPanel = {245, 247, 249, 255}, kSoft = {91, 101, 112, 255};

/// The colour of a class of report_style() in the light.
Rgba colour_of(const std::string& name, std::uint8_t alpha) {
  const Rgba colours[] = {estimate_colour, truth_colour, odometry_colour,
                          particle_colour, robot_colour, kSoft};
  Rgba colour = name.size() == 2 && name[1] >= '1' && name[1] <= '6' ? colours[name[1] - '1'] : ink;
  colour.alpha = alpha;
  return colour;
}

struct Pen {
  double width_px;  ///< 0: filled.
  std::uint8_t alpha = 255;
  double dash_px = 0.0;
};
/// As enum ShapeKind.
constexpr Pen kPens[] = {{1}, {0, 60}, {0, 160}, {2, 90}, {2}, {1.5, 255, 6}, {1.5, 255, 6}, {1.5}};

void draw_shape(Canvas& canvas, const PlotShape& shape, Pixel corner, double height_px) {
  const Pen& pen = kPens[static_cast<int>(shape.kind)];
  const Rgba colour = shape.kind == ShapeKind::grid ? kGrid : colour_of(shape.colour, pen.alpha);
  for (std::vector<Pixel> piece : shape.pieces) {
    for (Pixel& p : piece) p = {corner.x + kWidth_px * p.x, corner.y + height_px * p.y};
    if (shape.kind == ShapeKind::grid)  // on whole pixels, so that they are sharp
      for (Pixel& p : piece) p = {std::floor(p.x) + 0.5, std::floor(p.y) + 0.5};
    if (pen.width_px > 0.0)
      canvas.line(piece, pen.width_px, colour, pen.dash_px);
    else
      canvas.polygon(piece, colour);
  }
}

void draw_plot(Canvas& canvas, const Plot& plot, const Axis& x, std::int32_t top, std::int32_t height_px) {
  const std::optional<Axis> y = value_axis(plot);
  if (!y) return;
  const std::string unit = plot.unit.empty() ? "" : " [" + plot.unit + remark(plot, *y) + "]";
  canvas.text({kLeft_px, top + 0.5 * line_px}, plot.title + unit, ink);
  const Pixel corner = {kLeft_px, static_cast<double>(top + line_px)};
  canvas.clipped(corner.x, corner.y, corner.x + kWidth_px, corner.y + height_px, [&] {
    canvas.rectangle(corner.x, corner.y, corner.x + kWidth_px, corner.y + height_px, kPanel);
    for (const PlotShape& shape : shapes_of(plot, x, *y)) draw_shape(canvas, shape, corner, height_px);
  });
  for (const Tick& tick : ticks(*y))
    canvas.text({kLeft_px - margin_px / 2.0, corner.y + height_px * (1.0 - tick.at)}, tick.label, kSoft,
                Anchor::right);
}

void draw_x_labels(Canvas& canvas, const Axis& x, double row) {
  for (const Tick& tick : ticks(x))
    canvas.text({kLeft_px + kWidth_px * tick.at, row}, tick.label, kSoft, Anchor::middle);
  canvas.text({kLeft_px + kWidth_px + 2.0 * margin_px, row}, x.name, kSoft);
}

void draw_legend(Canvas& canvas, const Plot& plot, double row) {
  double x = kLeft_px;
  const auto add = [&](const std::string& label, const std::string& colour, std::uint8_t area) {
    if (label.empty()) return;
    if (area > 0)
      canvas.rectangle(x, row - 8, x + 34, row + 8, colour_of(colour, area));
    else
      canvas.line({{x, row}, {x + 34, row}}, 3, colour_of(colour, 255));
    canvas.text({x + 48, row}, label, ink);
    x += 48 + canvas.text_width(label) + 2 * margin_px;
  };
  for (const PlotSeries& s : plot.series) add(s.label, s.colour, s.kind == LineKind::area ? 160 : 0);
  for (const PlotBand& b : plot.bands) add(b.label, b.colour, 60);
}

}  // namespace

std::string plot_picture(const std::vector<Plot>& plots, const Axis& x, std::int32_t height_px) {
  const auto rows = static_cast<std::int32_t>(plots.size());
  const std::int32_t row_px = line_px + height_px + margin_px;
  Canvas canvas(kLeft_px + kWidth_px + kRight_px, rows * row_px + 2 * line_px + margin_px);
  std::int32_t top = margin_px / 2;
  for (const Plot& plot : plots) {
    draw_plot(canvas, plot, x, top, height_px);
    top += row_px;
  }
  draw_x_labels(canvas, x, top + 0.5);
  if (!plots.empty()) draw_legend(canvas, plots.front(), top + 1.3 * line_px);
  return canvas.png();
}

}  // namespace parloc::tools
