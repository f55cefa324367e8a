#include "tools/report/plots/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "tools/report/plots/plot_shapes.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr double kWidth = 1000, kHeight = 200;  // user units; stretched to the page

constexpr const char* kClasses[] = {"grid", "band",   "band full", "line pale",
                                    "line", "dashes", "dash",      "tick"};  // as enum ShapeKind

/// One piece of a path; a lone point shows as a dot.
void append_piece(std::string& d, const std::vector<Pixel>& piece) {
  auto out = std::back_inserter(d);
  for (std::size_t k = 0; k < piece.size(); ++k) {
    const double x = kWidth * piece[k].x, y = kHeight * piece[k].y;
    if (k > 0 && piece[k].x == piece[k - 1].x)
      fmt::format_to(out, "V{:.1f}", y);
    else if (k > 0 && piece[k].y == piece[k - 1].y)
      fmt::format_to(out, "H{:.1f}", x);
    else
      fmt::format_to(out, "{}{:.1f} {:.1f}", k == 0 ? 'M' : 'L', x, y);
  }
  if (piece.size() == 1) d += "h0";
}

std::string path_of(const PlotShape& shape) {
  std::string d;
  for (const std::vector<Pixel>& piece : shape.pieces) {
    append_piece(d, piece);
    if ((shape.kind == ShapeKind::band || shape.kind == ShapeKind::area) && !d.empty()) d += 'Z';
  }
  if (d.empty()) return "";
  return fmt::format("<path class=\"{} {}\" d=\"{}\"/>", kClasses[static_cast<int>(shape.kind)],
                     escape_html(shape.colour), d);
}

/// Around the origin, in pixels of the page.
std::string marker_path(const PlotSeries& series) {
  constexpr const char* kMarkers[] = {"", "M-3.6 0a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0 -7.2 0Z",
                                      "M-3.4 -3.4h6.8v6.8h-6.8Z", "M0 -4l4 7h-8Z",
                                      "M0 -4.6l4.6 4.6l-4.6 4.6l-4.6 -4.6Z"};  // as enum Marker
  if (series.marker == Marker::none) return "";
  return fmt::format("<path class=\"{} {}\" d=\"{}\"/>", series.dashed ? "hollow" : "solid",
                     escape_html(series.colour), kMarkers[static_cast<int>(series.marker)]);
}

/// Over the stretched lines, as they must keep their form.
std::string markers(const Plot& plot, const Axis& x, const Axis& y) {
  std::string svg;
  for (const PlotSeries& s : plot.series) {
    const std::string path = marker_path(s);
    for (std::size_t k = 0; !path.empty() && k < std::min(s.x.size(), s.y.size()); ++k) {
      if (!x.takes(s.x[k]) || !y.takes(s.y[k])) continue;
      svg += fmt::format("<svg x=\"{:.2f}%\" y=\"{:.2f}%\">{}</svg>", 100 * x.fraction(s.x[k]),
                         100 * (1.0 - y.fraction(s.y[k])), path);
    }
  }
  return svg.empty() ? "" : "<svg class=\"points\" aria-hidden=\"true\">" + svg + "</svg>";
}

std::string series_key(const PlotSeries& s) {
  if (s.label.empty()) return "";
  return fmt::format(
      "<span class=\"key\"><svg viewBox=\"-16 -7 32 14\" aria-hidden=\"true\"><path class=\"{} {}\" "
      "d=\"M-15 0H15\"/>{}</svg>{}</span>",
      s.dashed ? "dashes" : "line", escape_html(s.colour), marker_path(s), escape_html(s.label));
}

std::string legend(const Plot& plot) {
  std::string html;
  const auto add = [&](const std::string& kind, const std::string& colour, const std::string& label) {
    if (label.empty()) return;
    html += fmt::format("<span class=\"key\"><i class=\"{} {}\"></i>{}</span>", kind, escape_html(colour),
                        escape_html(label));
  };
  for (const PlotSeries& s : plot.series) html += series_key(s);
  for (const PlotBand& b : plot.bands) add("area", b.colour, b.label);
  for (const PlotLevel& l : plot.levels) add("dash", l.colour, l.labelled_there ? "" : l.label);
  for (const PlotMarks& m : plot.marks) add("tick", m.colour, m.x.empty() ? "" : m.label);
  return html;
}

std::string area(const Plot& plot, const Axis& x, const Axis& y) {
  std::string html = fmt::format(
      "<div class=\"area\"><svg viewBox=\"0 0 {:.0f} {:.0f}\" preserveAspectRatio=\"none\" role=\"img\" "
      "aria-label=\"{}\">",
      kWidth, kHeight, escape_html(plot.title));
  for (const PlotShape& shape : shapes_of(plot, x, y)) html += path_of(shape);
  html += "</svg>" + markers(plot, x, y);
  for (const PlotLevel& l : plot.levels) {
    if (l.labelled_there && y.takes(l.y))
      html += fmt::format("<span style=\"bottom:{:.2f}%\">{}</span>", 100 * y.fraction(l.y),
                          escape_html(l.label));
  }
  return html + "<div class=\"now\"></div></div>";
}

}  // namespace

std::string render_plot(const Plot& plot, const Axis& x) {
  const std::optional<Axis> fitted = value_axis(plot);
  if (!fitted) return "";
  const Axis& y = *fitted;
  const std::string unit = plot.unit.empty() ? "" : " [" + escape_html(plot.unit) + remark(plot, y) + "]";
  std::string html = "<figure class=\"plot\"><figcaption><b>" + escape_html(plot.title) + "</b>" + unit +
                     (plot.legend ? legend(plot) : "") + "</figcaption><div class=\"axes\"><div class=\"y\">";
  for (const Tick& t : ticks(y))
    html += fmt::format("<span style=\"top:{:.2f}%\">{}</span>", 100 * (1.0 - t.at), t.label);
  html += "</div>" + area(plot, x, y) + "<div class=\"x\">";
  for (const Tick& t : ticks(x))
    html += fmt::format("<span style=\"left:{:.2f}%\">{}</span>", 100 * t.at, t.label);
  return html + "<em>" + escape_html(x.name) + "</em></div></div></figure>\n";
}

std::string render_legend(const std::vector<PlotSeries>& series) {
  std::string html = "<p class=\"legend\">";
  for (const PlotSeries& s : series) html += series_key(s);
  return html + "</p>\n";
}

}  // namespace parloc::tools
