// The part of the report that shows a map in the making.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/report/map_view.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t most_image_px = 1000;

/// The part of a moment's grid that lies under `view`, as an image of at most most_image_px a side.
MapView window_under(const MapView& view, const GridMap& map) {
  const Pose corner =
      relative(compose(view.T_map_grid, {static_cast<double>(view.first_i) * view.cell_m,
                                         static_cast<double>(view.first_j) * view.cell_m, 0.0}),
               map.T_map_grid);
  MapView window;
  window.T_map_grid = map.T_map_grid, window.cell_m = map.resolution_m;
  window.first_i = static_cast<std::int64_t>(std::floor(corner.x_m / window.cell_m + 1e-6));
  window.first_j = static_cast<std::int64_t>(std::floor(corner.y_m / window.cell_m + 1e-6));
  const auto cells = [&](std::int32_t px) {
    return static_cast<std::int64_t>(std::ceil(px * view.pixel_m() / window.cell_m - 1e-6));
  };
  const std::int64_t width = cells(view.width_px), height = cells(view.height_px);
  window.down = (std::max(width, height) + most_image_px - 1) / most_image_px;
  window.width_px = static_cast<std::int32_t>((width + window.down - 1) / window.down);
  window.height_px = static_cast<std::int32_t>((height + window.down - 1) / window.down);
  return window;
}

/// The moment's cells where they lie in the figure.
std::string image(const GridMap& map, const MapView& view) {
  const MapView window = window_under(view, map);
  const Pose corner = compose(window.T_map_grid, {static_cast<double>(window.first_i) * window.cell_m,
                                                  static_cast<double>(window.first_j) * window.cell_m, 0.0});
  const Pixel lower_left = view.to_pixel(corner.x_m, corner.y_m);
  const double scale = window.pixel_m() / view.pixel_m();
  return fmt::format(
      "<image class=\"cells\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
      "preserveAspectRatio=\"none\" href=\"{}\"/>",
      lower_left.x, lower_left.y - window.height_px * scale, window.width_px * scale,
      window.height_px * scale, map_data_uri(map, window));
}

std::string layer(const MapMoment& moment, const MapView& view, const Axis& axis, std::size_t index,
                  bool shown) {
  const Snapshot& state = moment.state;
  return moment_group("grown", state.stamp_s, axis, shown) + fmt::format("<g id=\"grown{}\">", index) +
         image(moment.map, view) + svg_path("c1", track_path(moment.path, view, {1500, 1.0})) +
         cloud(state, view, fmt::format("grown_cloud{}", index)) + "</g>" +
         dot("robot c5", state.pose, view) +
         arrow(state.pose, view, 0.04 * std::max(view.width_px, view.height_px)) + "</g>";
}

std::string told(const MapMoment& moment, const Axis& axis, bool shown) {
  std::string html = shown ? "<dl class=\"told\">" : "<dl class=\"told\" style=\"display:none\">";
  const auto add = [&](const std::string& key, const std::string& value) {
    html += "<div><dt>" + escape_html(key) + "</dt><dd>" + escape_html(value) + "</dd></div>";
  };
  add("time in the log", time_text(axis, moment.state.stamp_s));
  for (const Fact& fact : moment.facts) add(fact.key, fact.value);
  return html + "</dl>\n";
}

/// Small, for choosing and for those without scripts.
std::string frame(const MapMoment& moment, const MapView& view, const Axis& axis, std::size_t index) {
  const std::string when = time_text(axis, moment.state.stamp_s);
  return fmt::format(
      "<figure><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"The map at {}\"><use "
      "href=\"#grown{}\"/></svg><figcaption>{}</figcaption></figure>",
      view.width_px, view.height_px, when, index, when);
}

}  // namespace

std::string growth_figures(const RunReport& report, const MapView& view, const Axis& axis) {
  const std::vector<std::size_t> moments = evenly_spaced(report.growth.size(), kMostMoments);
  if (moments.empty()) return "";
  std::string drawing;
  for (std::size_t k = 0; k < moments.size(); ++k)
    drawing += layer(report.growth[moments[k]], view, axis, k, k + 1 == moments.size());
  std::string html =
      "<h2>How the map grew</h2>\n<figure><figcaption><b>The map of the most likely particle</b>" +
      legend_key("line c1", "its way") + legend_key("dot c4", "particles") + "</figcaption>\n" +
      map_frame(view, "The map while it grew", drawing, 75.0) + "</figure>\n";
  html += fmt::format(
      "<div class=\"moment scripted\" hidden><button id=\"play\" type=\"button\">Play</button><label "
      "for=\"grow\">The map at</label><input type=\"range\" id=\"grow\" min=\"0\" max=\"{}\" "
      "value=\"{}\"/><output id=\"grow-at\">{}</output></div>\n",
      moments.size() - 1, moments.size() - 1, time_text(axis, report.growth[moments.back()].state.stamp_s));
  for (std::size_t k = 0; k < moments.size(); ++k)
    html += told(report.growth[moments[k]], axis, k + 1 == moments.size());
  html += "<div class=\"frames\">";
  for (std::size_t k = 0; k < moments.size(); ++k) html += frame(report.growth[moments[k]], view, axis, k);
  html += "</div>\n";
  return report.growth_note.empty()
             ? html
             : html + "<p class=\"note\">" + escape_html(report.growth_note) + "</p>\n";
}

}  // namespace parloc::tools
