#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

#include "tools/evaluate/relations_tables.h"
#include "tools/report/machine/build_info.h"
#include "tools/report/map_view.h"
#include "tools/report/plots/xy_plot.h"
#include "tools/report/report_marks.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools::evaluate {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr std::int32_t kLeastMap_px = 600, kMostMap_px = 1600;

/// What is smaller is drawn there: the axis is logarithmic.
constexpr double kLeastDrawn_m = 1e-4, kLeastDrawn_deg = 1e-3;

Curve upright(const std::string& label, const char* colour, double at) {
  return {label, colour, Marker::circle, true, {at, at}, {0.0, 100.0}, false};
}

XyPlot share_plot(const char* title, const char* x_name, std::vector<double> values, double mean,
                  double least) {
  for (double& v : values) v = std::max(v, least);
  XyPlot plot;
  plot.title = title;
  plot.x_name = x_name;
  plot.x_logarithmic = true;
  plot.y_logarithmic = false;
  plot.unit = YUnit::plain;
  plot.y_span = {0.0, 100.0};
  for (double tick = least; tick < 2e3; tick *= 10.0) plot.x_ticks.push_back(tick);
  const double most = *std::max_element(values.begin(), values.end());
  plot.curves.push_back(cumulative_curve("this trajectory", "c1", values, values.size(), most));
  plot.curves.push_back(upright("its mean", "c1", std::max(mean, least)));
  return plot;
}

std::string plots(const RelationsReport& r) {
  std::vector<double> translations_m, rotations_deg;
  for (const RelationError& e : r.errors.each) {
    translations_m.push_back(e.translation_m);
    rotations_deg.push_back(kDegrees * e.rotation_rad);
  }
  XyPlot translation = share_plot("Relations with at most that error in translation, %", "m",
                                  std::move(translations_m), r.errors.translation_mean_m, kLeastDrawn_m);
  const std::array<const char*, kPublishedMethods.size()> colours{"c5", "c2", "c4"};
  for (std::size_t m = 0; r.log != nullptr && m < colours.size(); ++m)
    translation.curves.push_back(upright(fmt::format("{}: published mean", kPublishedMethods[m]), colours[m],
                                         r.log->errors[m].mean_m));
  const XyPlot rotation = share_plot("... in rotation, %", "degrees", std::move(rotations_deg),
                                     kDegrees * r.errors.rotation_mean_rad, kLeastDrawn_deg);
  return "<div class=\"xys\">" + render(translation) + render(rotation) + "</div>\n" +
         render_legend(translation.curves);
}

Table largest_table(const std::vector<RelationError>& largest) {
  Table table;
  table.columns = {{"", "from [s]"}, {"", "to [s]"}, {"", "translation [m]"}, {"", "rotation [deg]"}};
  for (const RelationError& e : largest)
    table.rows.push_back({fmt::format("{:.6f}", e.stamp_1_s), fmt::format("{:.6f}", e.stamp_2_s),
                          fmt::format("{:.3f}", e.translation_m),
                          fmt::format("{:.2f}", kDegrees * e.rotation_rad)});
  return table;
}

/// A line between the two poses of a relation, with a tip that says how far off they are.
std::string drawn(const RelationError& e, const MapView& view) {
  if (!drawable_point(e.pose_1.x_m, e.pose_1.y_m) || !drawable_point(e.pose_2.x_m, e.pose_2.y_m)) return "";
  const Pixel from = view.to_pixel(e.pose_1.x_m, e.pose_1.y_m);
  const Pixel to = view.to_pixel(e.pose_2.x_m, e.pose_2.y_m);
  return fmt::format(
      "<g><title>{:.3f} m, {:.2f} degrees</title><path class=\"between c5\" d=\"M{:.1f} {:.1f}L{:.1f} "
      "{:.1f}\"/><path class=\"pair c5\" d=\"M{:.1f} {:.1f}h0M{:.1f} {:.1f}h0\"/></g>",
      e.translation_m, kDegrees * e.rotation_rad, from.x, from.y, to.x, to.y, from.x, from.y, to.x, to.y);
}

std::string map_figure(const RelationsReport& r, const std::vector<RelationError>& largest) {
  RunReport only_path;
  only_path.estimate = r.trajectory;
  const std::optional<MapView> fitted = fit_view(only_path, kLeastMap_px, kMostMap_px);
  if (!fitted) return "";
  const MapView& view = *fitted;
  std::string html =
      "<figure><figcaption><span class=\"key\"><i class=\"line c6\"></i>trajectory</span><span "
      "class=\"key\"><i class=\"dot c5\"></i>the two poses of a relation</span></figcaption>";
  html += fmt::format(
      "<div class=\"map\" style=\"max-width:{:.1f}vh\"><svg viewBox=\"0 0 {} {}\" role=\"img\" "
      "aria-label=\"Trajectory with the largest errors\"><path class=\"way c6\" d=\"{}\"/>",
      85.0 * view.width_px / view.height_px, view.width_px, view.height_px,
      track_path(r.trajectory, view, {20000, 0.33}));
  for (const RelationError& e : largest) html += drawn(e, view);
  return html + "</svg>" + scale_bar(view) + "</div></figure>\n";
}

constexpr const char* kStyle =
    ".way{stroke-width:1.2px;opacity:.6}.between{stroke-width:2.5px}.pair{stroke-width:9px}th{width:22%;"
    "overflow-wrap:normal}table.numbers th{width:auto}";

}  // namespace

std::string html_page(const RelationsReport& r) {
  std::string html = page_head("parloc evaluate: relation error", r.date, r.command, kStyle);
  html += facts_table(origin_lines(r), "summary");
  html += html_text(error_table(r)) + html_text(published_table(r));
  html += "<h2>How large</h2>\n" + plots(r);
  const std::vector<RelationError> largest = largest_errors(r.errors);
  html +=
      "<h2>Where the largest errors are</h2>\n" + map_figure(r, largest) + html_text(largest_table(largest));
  html += fmt::format("<p class=\"note\">parloc {}{}</p>\n", kVersion,
                      kCommit[0] == '\0' ? "" : fmt::format(", commit {}", kCommit));
  return html + "</body></html>\n";
}

}  // namespace parloc::tools::evaluate
