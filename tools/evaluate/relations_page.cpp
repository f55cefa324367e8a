#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <utility>

#include "tools/evaluate/relations_tables.h"
#include "tools/report/html_page.h"
#include "tools/report/machine/machine.h"
#include "tools/report/map_view.h"
#include "tools/report/plots/svg_plot.h"
#include "tools/report/report_marks.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools::evaluate {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr std::int32_t kLeastMap_px = 600, kMostMap_px = 1600;

/// What is smaller is drawn there: the axis is logarithmic.
constexpr double kLeastDrawn_m = 1e-4, kLeastDrawn_deg = 1e-3;

Plot share_plot(const char* title, std::vector<double> values, double mean, double least) {
  for (double& v : values) v = std::max(v, least);
  const double most = *std::max_element(values.begin(), values.end());
  Plot plot{title, "", PlotScale::from_zero};
  plot.legend = false;
  plot.series = {cumulative_series("this trajectory", "c1", values, values.size(), most),
                 upright("its mean", "c1", std::max(mean, least), 0.0, 100.0)};
  return plot;
}

std::string plots(const RelationsReport& r) {
  std::vector<double> translations_m, rotations_deg;
  for (const RelationError& e : r.errors.each) {
    translations_m.push_back(e.translation_m);
    rotations_deg.push_back(kDegrees * e.rotation_rad);
  }
  Plot translation = share_plot("Relations with at most that error in translation, %",
                                std::move(translations_m), r.errors.translation_mean_m, kLeastDrawn_m);
  const std::array<const char*, kPublishedMethods.size()> colours{"c5", "c2", "c4"};
  for (std::size_t m = 0; r.log != nullptr && m < colours.size(); ++m)
    translation.series.push_back(upright(fmt::format("{}: published mean", kPublishedMethods[m]), colours[m],
                                         r.log->errors[m].mean_m, 0.0, 100.0));
  const Plot rotation = share_plot("... in rotation, %", std::move(rotations_deg),
                                   kDegrees * r.errors.rotation_mean_rad, kLeastDrawn_deg);
  return "<div class=\"sizes\">" + render_plot(translation, size_axis(translation, "m", true)) +
         render_plot(rotation, size_axis(rotation, "degrees", true)) + "</div>\n" +
         render_legend(translation.series);
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
  const std::optional<MapView> view = fit_view(only_path, kLeastMap_px, kMostMap_px);
  if (!view) return "";
  std::string drawing = svg_path("way c6", track_path(r.trajectory, *view, {20000, 0.33}));
  for (const RelationError& e : largest) drawing += drawn(e, *view);
  return "<figure><figcaption>" + legend_key("line c6", "trajectory") +
         legend_key("dot c5", "the two poses of a relation") + "</figcaption>" +
         map_frame(*view, "Trajectory with the largest errors", drawing) + "</figure>\n";
}

constexpr const char* kStyle =
    ".way{stroke-width:1.2px;opacity:.6}.between{stroke-width:2.5px}.pair{stroke-width:9px}th{width:22%;"
    "overflow-wrap:normal}table.numbers th{width:auto}";

}  // namespace

std::string html_page(const RelationsReport& r) {
  std::string html = page_head("parloc evaluate: relation error", r.date, r.command, kStyle);
  html += facts_table(origin_facts(r), "summary");
  html += html_text(error_table(r)) + html_text(published_table(r));
  html += "<h2>How large</h2>\n" + plots(r);
  const std::vector<RelationError> largest = largest_errors(r.errors);
  html +=
      "<h2>Where the largest errors are</h2>\n" + map_figure(r, largest) + html_text(largest_table(largest));
  html += "<p class=\"note\">" + version_text() + "</p>\n";
  return html + "</body></html>\n";
}

}  // namespace parloc::tools::evaluate
