#include "tools/evaluate/relations.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <utility>

#include "common/error.h"
#include "common/math/angle_units.h"
#include "tools/report/machine/machine.h"
#include "tools/report/map_view.h"
#include "tools/report/plots/plot.h"
#include "tools/report/report_sections.h"
#include "tools/report/result_parts.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools::evaluate {
namespace {

constexpr std::size_t kLargest = 10;

std::string mean_and_std(double mean_m, double std_m) {
  return fmt::format("{:.3f} +- {:.3f}", mean_m, std_m);
}

Json published_json(const RelationsReport& r) {
  Json figures = Json::array();
  for (const PublishedLog* log : published_beside(r))
    for (std::size_t m = 0; m < kPublishedMethods.size(); ++m)
      figures.push_back({{"dataset", log->name},
                         {"method", kPublishedMethods[m]},
                         {"translation_mean_m", log->errors[m].mean_m},
                         {"translation_std_m", log->errors[m].std_m}});
  return {{"source", kPublishedSource}, {"figures", figures}};
}

Json largest_json(const RelationsReport& r) {
  Json largest = Json::array();
  for (const RelationError& e : largest_errors(r.errors))
    largest.push_back({{"stamp_1_s", e.stamp_1_s},
                       {"stamp_2_s", e.stamp_2_s},
                       {"translation_m", e.translation_m},
                       {"rotation_rad", e.rotation_rad}});
  return largest;
}

constexpr std::int32_t kLeastPicture_px = 600, kMostPicture_px = 1600;

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
    rotations_deg.push_back(kDegPerRad * e.rotation_rad);
  }
  Plot translation = share_plot("Relations with at most that error in translation, %",
                                std::move(translations_m), r.errors.translation_mean_m, kLeastDrawn_m);
  const std::array<const char*, kPublishedMethods.size()> colours{"c5", "c2", "c4"};
  for (std::size_t m = 0; r.log != nullptr && m < colours.size(); ++m)
    translation.series.push_back(upright(fmt::format("{}: published mean", kPublishedMethods[m]), colours[m],
                                         r.log->errors[m].mean_m, 0.0, 100.0));
  const Plot rotation = share_plot("... in rotation, %", std::move(rotations_deg),
                                   kDegPerRad * r.errors.rotation_mean_rad, kLeastDrawn_deg);
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
                          fmt::format("{:.2f}", kDegPerRad * e.rotation_rad)});
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
      e.translation_m, kDegPerRad * e.rotation_rad, from.x, from.y, to.x, to.y, from.x, from.y, to.x, to.y);
}

std::string map_figure(const RelationsReport& r, const std::vector<RelationError>& largest) {
  RunReport only_path;
  only_path.estimate = r.trajectory;
  const std::optional<MapView> view = fit_view(only_path, kLeastPicture_px, kMostPicture_px);
  if (!view) return "";
  std::string drawing = svg_path("way c6", track_path(r.trajectory, *view, {20000, 0.33}));
  for (const RelationError& e : largest) drawing += drawn(e, *view);
  return "<figure><figcaption>" + legend_key("line c6", "trajectory") +
         legend_key("dot c5", "the two poses of a relation") + "</figcaption>" +
         map_frame(*view, "Trajectory with the largest errors", drawing) + "</figure>\n";
}

constexpr const char* kRelationsStyle =
    ".way{stroke-width:1.2px;opacity:.6}.between{stroke-width:2.5px}.pair{stroke-width:9px}th{width:22%;"
    "overflow-wrap:normal}table.numbers th{width:auto}";

}  // namespace

Facts origin_facts(const RelationsReport& r) {
  const RelationErrors& e = r.errors;
  Facts lines{{"trajectory", fmt::format("{}, {} poses", r.trajectory_path, r.trajectory.size())},
              {"relations", fmt::format("{}, {} of {} have both poses in the trajectory", r.relations_path,
                                        e.compared, e.compared + e.without_pose)}};
  if (e.repeated_stamps > 0)
    add_fact(lines, "warning", "{} the stamp of an earlier one, which is the one that counts",
             e.repeated_stamps == 1 ? "1 pose has" : fmt::format("{} poses have", e.repeated_stamps));
  return lines;
}

Table error_table(const RelationsReport& r) {
  const RelationErrors& e = r.errors;
  Table table;
  table.title = "Relation error";
  table.columns = {{"", "", true}, {"", "mean"}, {"", "std"}, {"", "RMSE"}, {"", "median"}, {"", "max"}};
  const auto add = [&](const char* name, int decimals, double unit, const std::vector<double>& values) {
    std::vector<std::string> row{name};
    for (const double v : values) row.push_back(fmt::format("{:.{}f}", unit * v, decimals));
    table.rows.push_back(row);
  };
  add("translation [m]", 4, 1.0,
      {e.translation_mean_m, e.translation_std_m, e.translation_rmse_m, e.translation_median_m,
       e.translation_max_m});
  add("rotation [deg]", 2, kDegPerRad,
      {e.rotation_mean_rad, e.rotation_std_rad, e.rotation_rmse_rad, e.rotation_median_rad,
       e.rotation_max_rad});
  return table;
}

std::vector<const PublishedLog*> published_beside(const RelationsReport& r) {
  if (r.log != nullptr) return {r.log};
  std::vector<const PublishedLog*> all;
  for (const PublishedLog& log : kPublishedLogs) all.push_back(&log);
  return all;
}

Table published_table(const RelationsReport& r) {
  Table table;
  table.title = fmt::format("Published translation, mean +- std [m] ({})", kPublishedSource);
  table.columns = {{"", "log", true}};
  if (r.log != nullptr) table.columns.push_back({"", "this trajectory"});
  for (const char* method : kPublishedMethods) table.columns.push_back({"", method});
  for (const PublishedLog* log : published_beside(r)) {
    std::vector<std::string> row{log->name};
    if (r.log != nullptr)
      row.push_back(mean_and_std(r.errors.translation_mean_m, r.errors.translation_std_m));
    for (const PublishedError& error : log->errors) row.push_back(mean_and_std(error.mean_m, error.std_m));
    table.rows.push_back(row);
  }
  return table;
}

std::vector<RelationError> largest_errors(const RelationErrors& errors) {
  std::vector<RelationError> largest = errors.each;
  std::stable_sort(largest.begin(), largest.end(), [](const RelationError& a, const RelationError& b) {
    return a.translation_m > b.translation_m;
  });
  largest.resize(std::min(largest.size(), kLargest));
  return largest;
}

const PublishedLog& published_log(const std::string& name) {
  std::string names;
  for (const PublishedLog& log : kPublishedLogs) {
    if (name == log.name) return log;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", log.name);
  }
  throw Error(ErrorKind::usage, fmt::format("--dataset: expected one of {}, got '{}'", names, name));
}

RelationsReport judge_by_relations(const std::string& trajectory_path, const std::string& relations_path) {
  RelationsReport r;
  r.trajectory_path = trajectory_path;
  r.relations_path = relations_path;
  r.trajectory = read_tum(trajectory_path);
  r.errors = compare_relations(r.trajectory, read_relations(relations_path));
  if (r.errors.compared == 0)
    throw input_error(relations_path, 0,
                      fmt::format("expected relations between poses of {}: of {}, none has both its stamps "
                                  "there, equal to 6 decimals",
                                  trajectory_path, r.errors.without_pose));
  return r;
}

std::string terminal_text(const RelationsReport& r) {
  std::string text;
  text += aligned_text(origin_facts(r), 18);
  constexpr std::size_t kWidth = 100;
  return text + "\n" + terminal_text(error_table(r), kWidth) + "\n" +
         terminal_text(published_table(r), kWidth);
}

std::string json_text(const RelationsReport& r) {
  Json json{{"tool", "parloc evaluate"}, {"command", r.command}};
  json["build"] = build_json();
  json["trajectory"] = {{"file", r.trajectory_path},
                        {"poses", r.trajectory.size()},
                        {"repeated_stamps", r.errors.repeated_stamps}};
  json["relations_file"] = r.relations_path;
  json["relations"] = tools::relations_json(r.errors);
  json["dataset"] = r.log == nullptr ? Json(nullptr) : Json(r.log->name);
  json["published"] = published_json(r);
  json["largest"] = largest_json(r);
  return file_text(json);
}

std::string html_page(const RelationsReport& r) {
  std::string html = page_head("parloc evaluate: relation error", r.date, r.command, kRelationsStyle);
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
