#include "tools/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/file/output_file.h"
#include "common/math/angle_units.h"
#include "common/math/quantile.h"
#include "tools/report/plots/axis.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

Axis report_axis(const RunReport& report) {
  std::vector<double> stamps;
  for (const StampedPose& p : report.estimate) stamps.push_back(p.stamp_s);
  for (const StepRecord& s : report.steps) stamps.push_back(s.stamp_s);
  if (report.errors)
    stamps.insert(stamps.end(), report.errors->stamp_s.begin(), report.errors->stamp_s.end());
  for (const Snapshot& s : report.snapshots) stamps.push_back(s.stamp_s);
  return time_axis(stamps);
}

double length_m(const Trajectory& track) {
  double sum = 0.0;
  for (std::size_t k = 1; k < track.size(); ++k) {
    const double step = distance_m(track[k - 1].pose, track[k].pose);
    if (drawable(step)) sum += step;
  }
  return sum;
}

std::string distance_text(double value_m) {
  return std::abs(value_m) < 1.0 ? number_text(100 * value_m, 2) + " cm" : number_text(value_m, 2) + " m";
}

std::string degrees_text(double angle_rad) {
  return number_text(angle_rad * kDegPerRad, 2) + "\xC2\xB0";
}

Facts route_facts(const RunReport& report) {
  Facts facts;
  if (!report.estimate.empty()) {
    const auto& first = report.estimate.front();
    const auto& last = report.estimate.back();
    add_fact(facts, "Poses", "{} in {} s, {} m", report.estimate.size(),
             number_text(last.stamp_s - first.stamp_s, 1), number_text(length_m(report.estimate), 1));
  }
  if (report.map != nullptr) {
    const GridMap& map = *report.map;
    add_fact(facts, "Map", "{} \xC3\x97 {} m, cells of {} m", number_text(map.width * map.resolution_m, 1),
             number_text(map.height * map.resolution_m, 1), number_text(map.resolution_m, 4));
  }
  return facts;
}

Facts error_facts(const TrackErrors& e) {
  Facts facts;
  add_fact(facts, "Position error", "mean {}, RMSE {}, 95% {}, max {}", distance_text(e.position_mae_m),
           distance_text(e.position_rmse_m), distance_text(e.position_p95_m),
           distance_text(e.position_max_m));
  add_fact(facts, "Heading error", "mean {}, RMSE {}, max {}", degrees_text(e.heading_mae_rad),
           degrees_text(e.heading_rmse_rad), degrees_text(e.heading_max_rad));
  std::string compared = fmt::format("{} poses", e.compared);
  if (e.without_truth > 0) compared += fmt::format(", {} without truth", e.without_truth);
  facts.push_back({"Compared with truth", compared});
  return facts;
}

Facts step_facts(const std::vector<StepRecord>& steps) {
  std::vector<double> times;
  std::size_t resampled = 0, lost = 0;
  for (const StepRecord& s : steps) {
    if (drawable(s.step_ms)) times.push_back(s.step_ms);
    resampled += s.resampled ? 1 : 0;
    lost += s.lost ? 1 : 0;
  }
  Facts facts;
  const std::vector<double> sorted = ascending(std::move(times));
  if (!sorted.empty()) {
    add_fact(facts, "Time per step", "median {} ms, 99% {} ms, max {} ms",
             number_text(nearest_rank(sorted, 50), 3), number_text(nearest_rank(sorted, 99), 3),
             number_text(sorted.back(), 3));
  }
  std::string text = fmt::format("{}, resampled in {}", steps.size(), resampled);
  if (lost > 0) text += fmt::format(", no particle fitted in {}", lost);
  facts.push_back({"Steps", text});
  return facts;
}

std::string warning_list(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return "";
  std::string html = "<div class=\"warning\"><b>Worked around</b><ul>";
  for (const std::string& warning : warnings) html += "<li>" + escape_html(warning) + "</li>";
  return html + "</ul></div>\n";
}

std::string detail_tables(const std::vector<FactTable>& tables) {
  if (tables.empty()) return "";
  std::string html = "<div class=\"tables\">";
  for (const FactTable& t : tables) {
    html += "<section><h2>" + escape_html(t.title) + "</h2>" + facts_table(t.facts, "facts") + "</section>\n";
  }
  return html + "</div>\n";
}

std::string page(const RunReport& report) {
  const Axis axis = report_axis(report);
  const std::string title = escape_html(report.title);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>parloc: " +
      title + "</title>\n<style>" + report_style() + "</style></head>\n<body>\n<h1>" + title + "</h1>\n";
  html += facts_table(summary_facts(report), "summary");
  html += warning_list(report.warnings);
  html += map_figures(report, axis);
  html += plot_figures(report, axis);
  html += detail_tables(report.details);
  if (!report.command_line.empty()) {
    html += "<h2>To repeat it</h2>\n<code>" + escape_html(report.command_line) + "</code>\n";
  }
  return html + "<script>" + report_script() + "</script>\n</body></html>\n";
}

}  // namespace

std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most) {
  const std::size_t kept = std::min(count, most);
  std::vector<std::size_t> indices;
  indices.reserve(kept);
  // 64-bit products: count and most stay far below 2^32.
  for (std::size_t k = 0; k < kept; ++k)
    indices.push_back(kept == 1 ? count - 1 : k * (count - 1) / (kept - 1));
  return indices;
}

const StampedPose* nearest_pose(const Trajectory& trajectory, double stamp_s) {
  const StampedPose* best = nullptr;
  for (const StampedPose& p : trajectory) {
    if (best == nullptr || std::abs(p.stamp_s - stamp_s) < std::abs(best->stamp_s - stamp_s)) best = &p;
  }
  return best;
}

Facts summary_facts(const RunReport& report) {
  Facts facts = report.summary;
  const auto append = [&](const Facts& more) { facts.insert(facts.end(), more.begin(), more.end()); };
  append(route_facts(report));
  if (report.errors) append(error_facts(*report.errors));
  if (!report.steps.empty()) append(step_facts(report.steps));
  return facts;
}

void write_report(const std::string& path, const RunReport& report) {
  replace_file(path, page(report));
}

}  // namespace parloc::tools
