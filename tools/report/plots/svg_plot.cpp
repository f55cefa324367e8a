#include "tools/report/plots/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <optional>

#include "tools/report/plots/plot_axis.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr int plot_columns = 1000;
constexpr double plot_width = 1000, plot_height = 200;  // user units; stretched to the page

double y_of(const ValueAxis& axis, double value) {
  return plot_height * (1.0 - axis.fraction(value));
}

/// Through the extremes of each column, or through the means.
std::string curve_path(const std::vector<EnvelopeColumn>& columns, const ValueAxis& axis, bool means) {
  std::string d;
  auto out = std::back_inserter(d);
  bool pen_down = false;
  for (const EnvelopeColumn& c : columns) {
    const char command = pen_down && !c.gap_before ? 'L' : 'M';
    const double low_y = y_of(axis, means ? c.mean : c.low), high_y = y_of(axis, means ? c.mean : c.high);
    fmt::format_to(out, "{}{:.1f} {:.1f}", command, plot_width * c.x, low_y);
    if (low_y - high_y >= 0.05) fmt::format_to(out, "V{:.1f}", high_y);
    if (low_y - high_y < 0.05 && command == 'M') d += "h0";  // a lone sample shows as a dot
    pen_down = true;
  }
  return d;
}

std::string band_path(const std::vector<EnvelopeColumn>& columns, const ValueAxis& axis) {
  std::string d;
  auto out = std::back_inserter(d);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    fmt::format_to(out, "{}{:.1f} {:.1f}", k == 0 ? 'M' : 'L', plot_width * columns[k].x,
                   y_of(axis, columns[k].high));
  }
  for (std::size_t k = columns.size(); k-- > 0;) {
    fmt::format_to(out, "L{:.1f} {:.1f}", plot_width * columns[k].x, y_of(axis, -columns[k].high));
  }
  return d.empty() ? d : d + "Z";
}

/// One tick per column at most.
std::string marks_path(const PlotMarks& marks, const TimeAxis& axis) {
  std::vector<bool> seen(plot_columns + 1, false);
  for (const double stamp : marks.stamp_s) {
    const double fraction = drawable(stamp) ? axis.fraction(stamp) : -1.0;
    if (fraction >= 0.0 && fraction <= 1.0) seen[static_cast<std::size_t>(fraction * plot_columns)] = true;
  }
  std::string d;
  constexpr double row_height = 10;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k])
      fmt::format_to(std::back_inserter(d), "M{} {:.0f}v-8", k, plot_height - row_height * marks.row);
  }
  return d;
}

std::string grid_path(const std::vector<AxisTick>& y_ticks, const std::vector<AxisTick>& x_ticks,
                      const ValueAxis& axis, double x_span) {
  std::string d;
  auto out = std::back_inserter(d);
  for (const AxisTick& tick : y_ticks)
    fmt::format_to(out, "M0 {:.1f}H{:.0f}", y_of(axis, tick.value), plot_width);
  for (const AxisTick& tick : x_ticks) {
    fmt::format_to(out, "M{:.1f} 0V{:.0f}", plot_width * tick.value / x_span, plot_height);
  }
  return d;
}

void append_path(std::string& html, const std::string& classes, const std::string& d) {
  if (!d.empty()) fmt::format_to(std::back_inserter(html), "<path class=\"{}\" d=\"{}\"/>", classes, d);
}

std::string legend(const Plot& plot) {
  std::string html;
  const auto add = [&](const std::string& kind, const std::string& colour, const std::string& label) {
    if (label.empty()) return;
    fmt::format_to(std::back_inserter(html), "<span class=\"key\"><i class=\"{} {}\"></i>{}</span>", kind,
                   escape_html(colour), escape_html(label));
  };
  for (const PlotSeries& s : plot.series) add("line", s.colour, s.label);
  for (const PlotBand& b : plot.bands) add("area", b.colour, b.label);
  for (const PlotLevel& l : plot.levels) add("dash", l.colour, l.label);
  for (const PlotMarks& m : plot.marks) {
    if (!m.stamp_s.empty()) add("tick", m.colour, m.label);
  }
  return html;
}

/// One line; for a long series its means, over a pale area from minimum to maximum.
void append_series(std::string& svg, const PlotSeries& series, const TimeAxis& time, const ValueAxis& axis) {
  const std::vector<EnvelopeColumn> columns = envelope(time, series.stamp_s, series.y, plot_columns);
  const std::string colour = escape_html(series.colour);
  const bool pale = crowded(columns);
  append_path(svg, (pale ? "line pale " : "line ") + colour, curve_path(columns, axis, false));
  if (pale) append_path(svg, "line " + colour, curve_path(columns, axis, true));
}

std::string drawing(const Plot& plot, const TimeAxis& time, const ValueAxis& axis, const std::string& grid) {
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {:.0f} {:.0f}\" preserveAspectRatio=\"none\" role=\"img\" "
      "aria-label=\"{}\">",
      plot_width, plot_height, escape_html(plot.title));
  append_path(svg, "grid", grid);
  for (const PlotBand& b : plot.bands) {
    append_path(svg, "band " + escape_html(b.colour),
                band_path(envelope(time, b.stamp_s, b.half, plot_columns), axis));
  }
  for (const PlotSeries& s : plot.series) append_series(svg, s, time, axis);
  for (const PlotLevel& l : plot.levels) {
    if (!drawable(l.y)) continue;
    append_path(svg, "dash " + escape_html(l.colour),
                fmt::format("M0 {:.1f}H{:.0f}", y_of(axis, l.y), plot_width));
  }
  for (const PlotMarks& m : plot.marks)
    append_path(svg, "tick " + escape_html(m.colour), marks_path(m, time));
  return svg + "</svg>";
}

}  // namespace

TimeAxis time_axis(const std::vector<double>& stamps_s) {
  double low = 0.0, high = 0.0;
  bool any = false;
  for (const double stamp : stamps_s) {
    if (!drawable(stamp)) continue;
    low = any ? std::min(low, stamp) : stamp;
    high = any ? std::max(high, stamp) : stamp;
    any = true;
  }
  const double span = high > low ? high - low : 1.0;
  if (span <= 600) return {low, span, 1, "s"};
  return span <= 3 * 3600 ? TimeAxis{low, span, 60, "min"} : TimeAxis{low, span, 3600, "h"};
}

std::vector<EnvelopeColumn> envelope(const TimeAxis& axis, const std::vector<double>& stamp_s,
                                     const std::vector<double>& y, int columns) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < std::min(stamp_s.size(), y.size()); ++k) {
    if (drawable(stamp_s[k])) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return stamp_s[a] < stamp_s[b]; });
  std::vector<EnvelopeColumn> result;
  bool gap = false;
  int last_column = -1;
  for (const std::size_t k : order) {
    if (!drawable(y[k])) {
      gap = true;
      continue;
    }
    const double x = std::clamp(axis.fraction(stamp_s[k]), 0.0, 1.0);
    const int column = static_cast<int>(x * columns);
    if (column == last_column) {
      result.back().low = std::min(result.back().low, y[k]);
      result.back().high = std::max(result.back().high, y[k]);
      result.back().mean += (y[k] - result.back().mean) / static_cast<double>(++result.back().samples);
    } else {
      result.push_back({x, y[k], y[k], y[k], 1, gap});
      gap = false;
    }
    last_column = column;
  }
  return result;
}

std::string render_plot(const Plot& plot, const TimeAxis& axis) {
  const std::optional<ValueAxis> fitted = value_axis(plot);
  if (!fitted) return "";
  const ValueAxis& value = *fitted;
  const std::vector<AxisTick> y_ticks = ticks(value), x_ticks = ticks(axis);
  const double x_span = axis.span_s / axis.unit_s;

  std::string html = "<figure class=\"plot\"><figcaption><b>" + escape_html(plot.title) + "</b> [" +
                     escape_html(plot.unit) + remark(value) + "]" + legend(plot) +
                     "</figcaption><div class=\"axes\"><div class=\"y\">";
  auto out = std::back_inserter(html);
  for (const AxisTick& t : y_ticks) {
    fmt::format_to(out, "<span style=\"top:{:.2f}%\">{}</span>", 100 * (1.0 - value.fraction(t.value)),
                   t.label);
  }
  html += "</div><div class=\"area\">" +
          drawing(plot, axis, value, grid_path(y_ticks, x_ticks, value, x_span)) +
          "<div class=\"now\"></div></div><div class=\"x\">";
  for (const AxisTick& t : x_ticks) {
    fmt::format_to(out, "<span style=\"left:{:.2f}%\">{}</span>", 100 * t.value / x_span, t.label);
  }
  return html + "<em>" + axis.unit + "</em></div></div></figure>\n";
}

}  // namespace parloc::tools
