#include "tools/report/plots/xy_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "tools/report/text/html_text.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools {
namespace {

constexpr double kWidth = 460, kHeight = 340;  // user units; text is scaled with the rest
constexpr double kLeft = 62, kRight = 14, kTop = 12, kBottom = 46;

struct Axis {
  double low = 0.0, high = 1.0;  // of log10 of the value if logarithmic
  bool logarithmic = false;

  bool takes(double value) const { return drawable(value) && (!logarithmic || value > 0.0); }
  double share(double value) const {
    return ((logarithmic ? std::log10(value) : value) - low) / (high - low);
  }
};

struct Frame {
  Axis x, y;
  double px(double value) const { return kLeft + x.share(value) * (kWidth - kLeft - kRight); }
  double py(double value) const { return kHeight - kBottom - y.share(value) * (kHeight - kTop - kBottom); }
  bool takes(const Curve& c, std::size_t k) const { return x.takes(c.x[k]) && y.takes(c.y[k]); }
};

Axis axis_over(const std::vector<double>& values, bool logarithmic) {
  Axis axis;
  axis.logarithmic = logarithmic;
  double low = 1e300, high = -1e300;
  for (const double value : values) {
    if (!axis.takes(value)) continue;
    low = std::min(low, logarithmic ? std::log10(value) : value);
    high = std::max(high, logarithmic ? std::log10(value) : value);
  }
  if (!(low <= high)) return axis;
  if (!logarithmic) low = std::min(low, 0.0);
  const double margin = std::max(0.04 * (high - low), logarithmic ? 0.05 : 1e-9);
  axis.low = logarithmic ? low - margin : low;
  axis.high = high + margin;
  return axis;
}

Frame frame_of(const XyPlot& plot) {
  std::vector<double> xs = plot.x_span, ys;
  for (const Curve& c : plot.curves) {
    xs.insert(xs.end(), c.x.begin(), c.x.end());
    ys.insert(ys.end(), c.y.begin(), c.y.end());
  }
  ys.insert(ys.end(), plot.y_span.begin(), plot.y_span.end());
  for (const Level& level : plot.levels) ys.push_back(level.y);
  return {axis_over(xs, plot.x_logarithmic), axis_over(ys, plot.y_logarithmic)};
}

/// A tick: as many digits as it needs, no more.
std::string tick_text(double value) {
  for (const auto& [size, letter] : {std::pair{1e9, " G"}, {1e6, " M"}, {1e4, " k"}}) {
    if (value >= size) return fmt::format("{:g}{}", value / (size == 1e4 ? 1e3 : size), letter);
  }
  return fmt::format("{:g}", value);
}

std::string y_label(double value, YUnit unit) {
  if (unit == YUnit::plain || value == 0.0) return tick_text(value);
  if (value >= 0.9995) return significant(value, value >= 100 ? 3 : 1) + " s";
  if (value >= 0.9995e-3) return significant(1e3 * value, 1) + " ms";
  return significant(1e6 * value, 1) + " \xC2\xB5s";
}

std::vector<double> y_ticks(const Axis& y) {
  std::vector<double> ticks;
  if (y.logarithmic) {
    for (int k = static_cast<int>(std::ceil(y.low)); k <= y.high; ++k) ticks.push_back(std::pow(10.0, k));
    return ticks;
  }
  const double decade = std::pow(10.0, std::floor(std::log10(y.high / 4)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * decade * 6 >= y.high) step = factor * decade;
  }
  for (double value = 0.0; value <= y.high; value += step) ticks.push_back(value);
  return ticks;
}

void append_text(std::string& svg, double x, double y, const char* anchor, const std::string& text) {
  fmt::format_to(std::back_inserter(svg), "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>", x,
                 y, anchor, escape_html(text));
}

void append_grid(std::string& svg, const XyPlot& plot, const Frame& f) {
  std::string lines, fine;
  for (const double tick : y_ticks(f.y)) {
    fmt::format_to(std::back_inserter(lines), "M{:.1f} {:.1f}H{:.1f}", kLeft, f.py(tick), kWidth - kRight);
    append_text(svg, kLeft - 6, f.py(tick) + 4.5, "end", y_label(tick, plot.unit));
    for (int part = 2; f.y.logarithmic && part < 10; ++part) {
      const double at = f.py(tick * part);
      if (at >= kTop) fmt::format_to(std::back_inserter(fine), "M{:.1f} {:.1f}h5", kLeft, at);
    }
  }
  for (const double tick : plot.x_ticks) {
    if (!f.x.takes(tick) || f.x.share(tick) < -1e-9 || f.x.share(tick) > 1.0) continue;
    fmt::format_to(std::back_inserter(lines), "M{:.1f} {:.1f}V{:.1f}", f.px(tick), kTop, kHeight - kBottom);
    append_text(svg, f.px(tick), kHeight - kBottom + 18, "middle", tick_text(tick));
  }
  append_text(svg, 0.5 * (kLeft + kWidth - kRight), kHeight - 8, "middle", plot.x_name);
  svg += "<path class=\"grid\" d=\"" + lines + fine + "\"/>";
}

std::string marker_path(Marker marker, double x, double y, double r) {
  switch (marker) {
    case Marker::circle:
      return fmt::format("M{:.1f} {:.1f}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z", x - r, y,
                         fmt::arg("r", r), fmt::arg("d", 2 * r));
    case Marker::square:
      return fmt::format("M{:.1f} {:.1f}h{d}v{d}h-{d}Z", x - r, y - r, fmt::arg("d", 2 * r));
    case Marker::triangle:
      return fmt::format("M{:.1f} {:.1f}l{r} {h}h-{w}Z", x, y - r, fmt::arg("r", r), fmt::arg("h", 1.8 * r),
                         fmt::arg("w", 2 * r));
    case Marker::diamond:
      return fmt::format("M{:.1f} {:.1f}l{r} {r}l-{r} {r}l-{r} -{r}Z", x, y - 1.2 * r,
                         fmt::arg("r", 1.2 * r));
  }
  return "";
}

void append_curve(std::string& svg, const Curve& c, const Frame& f) {
  std::string line, marks;
  for (std::size_t k = 0; k < std::min(c.x.size(), c.y.size()); ++k) {
    if (!f.takes(c, k)) continue;
    fmt::format_to(std::back_inserter(line), "{}{:.1f} {:.1f}", line.empty() ? 'M' : 'L', f.px(c.x[k]),
                   f.py(c.y[k]));
    if (c.marked) marks += marker_path(c.marker, f.px(c.x[k]), f.py(c.y[k]), 3.6);
  }
  const char* dashes = c.dashed ? " dashes" : "";
  fmt::format_to(std::back_inserter(svg), "<path class=\"curve{} {}\" d=\"{}\"/>", dashes, c.colour, line);
  fmt::format_to(std::back_inserter(svg), "<path class=\"{} {}\" d=\"{}\"/>", c.dashed ? "hollow" : "solid",
                 c.colour, marks);
}

}  // namespace

Curve cumulative_curve(const std::string& label, const std::string& colour, std::vector<double> values,
                       std::size_t all, double until) {
  constexpr std::size_t kMostPoints = 1000;
  std::sort(values.begin(), values.end());
  const auto percent = [&](std::size_t n) {
    return 100.0 * static_cast<double>(n) / static_cast<double>(all);
  };
  Curve c{label, colour, Marker::circle, false, {0.0}, {0.0}, false};
  const std::size_t stride = values.size() / kMostPoints + 1;
  for (std::size_t k = stride - 1; k < values.size(); k += stride) {
    c.x.insert(c.x.end(), {values[k], values[k]});
    c.y.insert(c.y.end(), {c.y.back(), percent(k + 1)});
  }
  c.x.push_back(until);
  c.y.push_back(percent(values.size()));
  return c;
}

std::string render(const XyPlot& plot) {
  const Frame f = frame_of(plot);
  const bool any = std::any_of(plot.curves.begin(), plot.curves.end(), [&](const Curve& c) {
    for (std::size_t k = 0; k < std::min(c.x.size(), c.y.size()); ++k)
      if (f.takes(c, k)) return true;
    return false;
  });
  if (!any) return "";
  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">", kWidth, kHeight,
                                escape_html(plot.title));
  append_grid(svg, plot, f);
  for (const Level& level : plot.levels) {
    if (!f.y.takes(level.y)) continue;
    fmt::format_to(std::back_inserter(svg), "<path class=\"level\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", kLeft,
                   f.py(level.y), kWidth - kRight);
    append_text(svg, kLeft + 10, f.py(level.y) - 5, "start", level.label);
  }
  for (const Curve& c : plot.curves) append_curve(svg, c, f);
  return "<figure class=\"xy\"><figcaption><b>" + escape_html(plot.title) + "</b></figcaption>" + svg +
         "</svg></figure>\n";
}

std::string render_legend(const std::vector<Curve>& curves) {
  std::string html = "<p class=\"legend\">";
  for (const Curve& c : curves) {
    const std::string line =
        "<path class=\"curve" + std::string(c.dashed ? " dashes " : " ") + c.colour + "\" d=\"M2 8H34\"/>";
    const std::string mark = !c.marked
                                 ? ""
                                 : "<path class=\"" + std::string(c.dashed ? "hollow " : "solid ") +
                                       c.colour + "\" d=\"" + marker_path(c.marker, 18, 8, 3.6) + "\"/>";
    html += "<span><svg viewBox=\"0 0 36 16\" aria-hidden=\"true\">" + line + mark + "</svg>" +
            escape_html(c.label) + "</span>";
  }
  return html + "</p>\n";
}

const char* bench_style() {
  return R"css(
.wide{overflow-x:auto}
table.numbers{width:auto;margin:.6rem 0 1.2rem}
.numbers caption{text-align:left;font-weight:600;padding:.3rem 0}
.numbers th,.numbers td{width:auto;text-align:right;padding:.15rem 0 .15rem 1.1rem;white-space:nowrap;font-size:.88rem}
.numbers .left{text-align:left}
.numbers tr>*:first-child{padding-left:0}
.numbers .group{text-align:center}
.numbers .within{font-weight:600}
.xys{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,20rem),1fr));gap:1rem 1.4rem}
.xy text{font:12.5px system-ui,sans-serif;fill:var(--soft)}
path.curve{stroke-width:2px}
path.dashes{stroke-width:1.5px;stroke-dasharray:5 4}
path.level{stroke:var(--text);stroke-width:1.2px;stroke-dasharray:2 3}
path.hollow{fill:var(--page);stroke-width:1.4px}
path.solid{stroke-width:1px}
.solid.c1{fill:var(--c1)}.solid.c2{fill:var(--c2)}.solid.c3{fill:var(--c3)}.solid.c4{fill:var(--c4)}
.solid.c5{fill:var(--c5)}.solid.c6{fill:var(--c6)}
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1.3rem;font-size:.9rem;margin:.6rem 0}
.legend span{display:inline-flex;align-items:center;gap:.4rem}
.legend svg{width:2.25rem;height:1rem}
summary{cursor:pointer;color:var(--soft);margin:.4rem 0}
)css";
}

}  // namespace parloc::tools
