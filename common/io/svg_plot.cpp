#include "common/io/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>

#include "common/io/html_text.h"

namespace parloc {
namespace {

constexpr int plot_columns = 1000;
constexpr double plot_width = 1000, plot_height = 200;  // user units; stretched to the page

/// The vertical axis: where a value lies, and its labelled ticks.
struct ValueAxis {
  double low = 0.0, high = 1.0;  // of log10 of the value if logarithmic
  bool logarithmic = false;
  double cut_off = 0.0;  // the largest value, if it lies outside

  double y(double value) const {
    const double v = logarithmic ? std::log10(std::max(value, 1e-30)) : value;
    const double fraction = std::clamp((v - low) / (high - low), -2.0, 3.0);  // what lies outside is clipped
    return plot_height * (1.0 - fraction);
  }
};

struct Tick {
  double value;
  std::string label;
};

double nice_step(double span, int about) {
  const double raw = span / about;
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= raw) return factor * decade;
  }
  return 10 * decade;
}

std::vector<Tick> linear_ticks(double low, double high, int about) {
  std::vector<Tick> ticks;
  const double step = nice_step(high - low, about);
  const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step))), 0, 12);
  const double first = std::ceil(low / step - 1e-9);
  for (int k = 0; k <= 2 * about; ++k) {
    const double value = (first + k) * step;
    if (value > high + 1e-9 * step) break;
    ticks.push_back({value, number_text(value, decimals)});
  }
  return ticks;
}

std::vector<Tick> log_ticks(double low, double high) {
  std::vector<Tick> ticks;
  const int stride = std::max(1, static_cast<int>((high - low) / 5));
  for (int k = static_cast<int>(std::ceil(low)); k <= high; k += stride) {
    const double value = std::pow(10.0, k);
    ticks.push_back({value, number_text(value, std::max(0, -k))});
  }
  return ticks;
}

std::vector<double> drawable_values(const std::vector<PlotSeries>& series) {
  std::vector<double> values;
  for (const PlotSeries& s : series)
    std::copy_if(s.y.begin(), s.y.end(), std::back_inserter(values), drawable);
  return values;
}

double largest_band(const std::vector<PlotBand>& bands) {
  double largest = 0.0;
  for (const PlotBand& band : bands) {
    for (const double half : band.half) {
      if (drawable(half)) largest = std::max(largest, std::abs(half));
    }
  }
  return largest;
}

/// The value that 98% of `values` stay below.
double usual_size(std::vector<double> values) {
  for (double& v : values) v = std::abs(v);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Errors of metres before the filter has settled would flatten the centimetres after it: they are cut off,
/// and the caption says how far they reach.
ValueAxis symmetric_axis(const std::vector<double>& values, double largest, double band) {
  const double usual = usual_size(values);
  const double shown = usual > 0.0 && largest > 8 * usual ? 2 * usual : largest;
  double limit = std::max(1.1 * shown, std::min(1.1 * band, 2.5 * shown));
  if (shown == 0.0) limit = band;
  if (limit <= 0.0) limit = 1.0;
  return {-limit, limit, false, largest > limit ? largest : 0.0};
}

/// Whether a few values are so far above the rest that a linear axis would flatten it.
bool wants_logarithm(std::vector<double>& values, double high) {
  auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle > 0.0 && high > 15.0 * *middle;
}

ValueAxis log_axis(const std::vector<double>& values, double high) {
  double least = high;
  for (const double v : values) {
    if (v > 1e-4 * high) least = std::min(least, v);
  }
  const double top = std::log10(high) + 0.05;
  return {std::min(std::floor(std::log10(least) * 4) / 4, top - 1.0), top, true, 0.0};
}

ValueAxis value_axis(const Plot& plot, std::vector<double> values) {
  for (const PlotLevel& level : plot.levels) {
    if (drawable(level.y)) values.push_back(level.y);
  }
  const auto [low_at, high_at] = std::minmax_element(values.begin(), values.end());
  double low = *low_at, high = *high_at;
  if (plot.scale == PlotScale::symmetric) {
    return symmetric_axis(values, std::max(std::abs(low), std::abs(high)), largest_band(plot.bands));
  }
  if (plot.scale == PlotScale::automatic && wants_logarithm(values, high)) return log_axis(values, high);
  if (plot.scale != PlotScale::linear) low = std::min(0.0, low);
  if (!(high > low)) low -= 0.5 * std::max(1.0, std::abs(low)), high = low + std::max(1.0, std::abs(high));
  return {low, high + 0.06 * (high - low), false, 0.0};
}

/// Whether columns stand for so many samples that a line through all of them would be a solid area.
bool crowded(const std::vector<EnvelopeColumn>& columns) {
  return std::any_of(columns.begin(), columns.end(), [](const EnvelopeColumn& c) { return c.samples > 2; });
}

/// Through the extremes of each column, or through the means.
std::string curve_path(const std::vector<EnvelopeColumn>& columns, const ValueAxis& axis, bool means) {
  std::string d;
  auto out = std::back_inserter(d);
  bool pen_down = false;
  for (const EnvelopeColumn& c : columns) {
    const char command = pen_down && !c.gap_before ? 'L' : 'M';
    const double low_y = axis.y(means ? c.mean : c.low), high_y = axis.y(means ? c.mean : c.high);
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
                   axis.y(columns[k].high));
  }
  for (std::size_t k = columns.size(); k-- > 0;) {
    fmt::format_to(out, "L{:.1f} {:.1f}", plot_width * columns[k].x, axis.y(-columns[k].high));
  }
  return d.empty() ? d : d + "Z";
}

/// One tick per column at most.
std::string marks_path(const std::vector<double>& stamp_s, const TimeAxis& axis) {
  std::vector<bool> seen(plot_columns + 1, false);
  for (const double stamp : stamp_s) {
    const double fraction = drawable(stamp) ? axis.fraction(stamp) : -1.0;
    if (fraction >= 0.0 && fraction <= 1.0) seen[static_cast<std::size_t>(fraction * plot_columns)] = true;
  }
  std::string d;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k]) fmt::format_to(std::back_inserter(d), "M{} {:.0f}v-8", k, plot_height);
  }
  return d;
}

std::string grid_path(const std::vector<Tick>& y_ticks, const std::vector<Tick>& x_ticks,
                      const ValueAxis& axis, double x_span) {
  std::string d;
  auto out = std::back_inserter(d);
  for (const Tick& tick : y_ticks) fmt::format_to(out, "M0 {:.1f}H{:.0f}", axis.y(tick.value), plot_width);
  for (const Tick& tick : x_ticks) {
    fmt::format_to(out, "M{:.1f} 0V{:.0f}", plot_width * tick.value / x_span, plot_height);
  }
  return d;
}

void append_path(std::string& html, const std::string& classes, const std::string& d) {
  if (!d.empty()) fmt::format_to(std::back_inserter(html), "<path class=\"{}\" d=\"{}\"/>", classes, d);
}

/// What a reader must know about the vertical axis.
std::string remark(const ValueAxis& axis) {
  if (axis.logarithmic) return ", logarithmic";
  return axis.cut_off > 0.0 ? ", peaks up to " + number_text(axis.cut_off, 2) : "";
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
                fmt::format("M0 {:.1f}H{:.0f}", axis.y(l.y), plot_width));
  }
  for (const PlotMarks& m : plot.marks)
    append_path(svg, "tick " + escape_html(m.colour), marks_path(m.stamp_s, time));
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
  const std::vector<double> values = drawable_values(plot.series);
  if (values.empty()) return "";
  const ValueAxis value = value_axis(plot, values);
  const std::vector<Tick> y_ticks =
      value.logarithmic ? log_ticks(value.low, value.high) : linear_ticks(value.low, value.high, 4);
  const double x_span = axis.span_s / axis.unit_s;
  const std::vector<Tick> x_ticks = linear_ticks(0.0, x_span, 6);

  std::string html = "<figure class=\"plot\"><figcaption><b>" + escape_html(plot.title) + "</b> [" +
                     escape_html(plot.unit) + remark(value) + "]" + legend(plot) +
                     "</figcaption><div class=\"axes\"><div class=\"y\">";
  auto out = std::back_inserter(html);
  for (const Tick& t : y_ticks) {
    fmt::format_to(out, "<span style=\"top:{:.2f}%\">{}</span>", 100 * value.y(t.value) / plot_height,
                   t.label);
  }
  html += "</div><div class=\"area\">" +
          drawing(plot, axis, value, grid_path(y_ticks, x_ticks, value, x_span)) +
          "<div class=\"now\"></div></div><div class=\"x\">";
  for (const Tick& t : x_ticks) {
    fmt::format_to(out, "<span style=\"left:{:.2f}%\">{}</span>", 100 * t.value / x_span, t.label);
  }
  return html + "<em>" + axis.unit + "</em></div></div></figure>\n";
}

}  // namespace parloc
