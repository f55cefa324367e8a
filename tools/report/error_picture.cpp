#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/file/output_file.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/picture_style.h"
#include "tools/report/plots/plot_axis.h"
#include "tools/report/report.h"
#include "tools/report/report_sections.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t area_width_px = 1000, area_height_px = 180;
constexpr std::int32_t left_px = 100, right_px = 76;
constexpr std::int32_t row_px = line_px + area_height_px + margin_px;
constexpr std::int32_t glyph_px = 7 * text_scale;
constexpr Rgba grid_colour = {216, 221, 227, 255}, soft = {91, 101, 112, 255};
constexpr Rgba pale_estimate = {0, 114, 178, 90}, band_colour = {0, 158, 115, 60};

double row_of(const ValueAxis& axis, double value) {
  return area_height_px * (1.0 - axis.fraction(value));
}

double column_of(const TimeAxis& time, const AxisTick& tick) {
  return area_width_px * tick.value * time.unit_s / time.span_s;
}

/// One upright line per column of pixels, straight between samples.
void draw_band(Canvas& area, const PlotBand& band, const TimeAxis& time, const ValueAxis& axis) {
  const std::vector<EnvelopeColumn> columns = envelope(time, band.stamp_s, band.half, area_width_px);
  for (std::size_t k = 1; k < columns.size(); ++k) {
    const EnvelopeColumn &from = columns[k - 1], &to = columns[k];
    const double x0 = std::floor(area_width_px * from.x), x1 = std::floor(area_width_px * to.x);
    for (double x = x0; x < x1; ++x) {
      const double half = from.high + (x - x0) / (x1 - x0) * (to.high - from.high);
      area.rectangle(x, row_of(axis, half), x + 1, row_of(axis, -half), band_colour);
    }
  }
}

/// Through the extremes of each column, or through the means.
void draw_curve(Canvas& area, const std::vector<EnvelopeColumn>& columns, const ValueAxis& axis, bool means,
                Rgba colour) {
  bool pen_down = false;
  Pixel last;
  for (const EnvelopeColumn& c : columns) {
    const double x = area_width_px * c.x;
    const double low = row_of(axis, means ? c.mean : c.low), high = row_of(axis, means ? c.mean : c.high);
    if (pen_down && !c.gap_before) area.line(last.x, last.y, x, low, 2, colour);
    area.line(x, low, x, high, 2, colour);
    last = {x, high}, pen_down = true;
  }
}

/// The plot without its labels, on a canvas of its own so that it is cut off at its edges.
Canvas plot_area(const Plot& plot, const TimeAxis& time, const ValueAxis& axis) {
  Canvas area(area_width_px, area_height_px, {245, 247, 249, 255});
  for (const AxisTick& tick : ticks(axis)) {
    const double y = std::floor(row_of(axis, tick.value));
    area.rectangle(0, y, area_width_px, y + 1, grid_colour);
  }
  for (const AxisTick& tick : ticks(time)) {
    const double x = std::floor(column_of(time, tick));
    area.rectangle(x, 0, x + 1, area_height_px, grid_colour);
  }
  for (const PlotBand& band : plot.bands) draw_band(area, band, time, axis);
  for (const PlotSeries& series : plot.series) {
    const std::vector<EnvelopeColumn> columns = envelope(time, series.stamp_s, series.y, area_width_px);
    const bool pale = crowded(columns);
    draw_curve(area, columns, axis, false, pale ? pale_estimate : estimate_colour);
    if (pale) draw_curve(area, columns, axis, true, estimate_colour);
  }
  return area;
}

void draw_plot(Canvas& canvas, const Plot& plot, const TimeAxis& time, std::int32_t top) {
  const std::optional<ValueAxis> axis = value_axis(plot);
  if (!axis) return;
  canvas.text(left_px, top + (line_px - glyph_px) / 2, plot.title + " [" + plot.unit + remark(*axis) + "]",
              text_scale, ink);
  const std::int32_t area_top = top + line_px;
  canvas.paste(plot_area(plot, time, *axis), left_px, area_top);
  for (const AxisTick& tick : ticks(*axis)) {
    canvas.text(left_px - margin_px / 2 - Canvas::text_width(tick.label, text_scale),
                area_top + static_cast<std::int32_t>(row_of(*axis, tick.value)) - glyph_px / 2, tick.label,
                text_scale, soft);
  }
}

/// The labels of the time axis, which all plots share.
void draw_time_labels(Canvas& canvas, const TimeAxis& time, std::int32_t top) {
  for (const AxisTick& tick : ticks(time)) {
    const std::int32_t middle = left_px + static_cast<std::int32_t>(column_of(time, tick));
    canvas.text(middle - Canvas::text_width(tick.label, text_scale) / 2, top, tick.label, text_scale, soft);
  }
  canvas.text(left_px + area_width_px + 2 * margin_px, top, time.unit, text_scale, soft);
}

void draw_key(Canvas& canvas, bool band, std::int32_t top) {
  const std::int32_t middle = top + line_px / 2, text_top = middle - glyph_px / 2;
  canvas.line(left_px, middle, left_px + 34, middle, 3, estimate_colour);
  canvas.text(left_px + 48, text_top, "estimate minus truth", text_scale, ink);
  if (!band) return;
  const std::int32_t x =
      left_px + 48 + Canvas::text_width("estimate minus truth", text_scale) + 2 * margin_px;
  canvas.rectangle(x, middle - 8, x + 34, middle + 8, band_colour);
  canvas.text(x + 48, text_top, "3 sigma of the particles", text_scale, ink);
}

}  // namespace

void write_error_picture(const std::string& path, const RunReport& report) {
  const std::vector<Plot> plots = error_plots(report);
  if (plots.empty()) throw Error(ErrorKind::output, path + ": cannot be written: no errors to show");
  const TimeAxis time = time_axis(report.errors->stamp_s);
  const auto rows = static_cast<std::int32_t>(plots.size());
  Canvas canvas(left_px + area_width_px + right_px, rows * row_px + 2 * line_px + margin_px, white);
  for (std::int32_t k = 0; k < rows; ++k)
    draw_plot(canvas, plots[static_cast<std::size_t>(k)], time, k * row_px + margin_px / 2);
  draw_time_labels(canvas, time, rows * row_px);
  draw_key(canvas, !plots.front().bands.empty(), rows * row_px + line_px);
  replace_file(path, encode_png_rgb(canvas.width(), canvas.height(), canvas.pixels()));
}

}  // namespace parloc::tools
