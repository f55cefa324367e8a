#include <fmt/format.h>

#include "tools/evaluate/families/families_report.h"
#include "tools/report/plots/plot.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools::families {
namespace {

/// What was said against what was.
std::string reliability_plot(const FamilySummary& family) {
  const PlotSeries ideal{"as it should be", "c6",         {0.0, 1.0}, {0.0, 1.0},
                         LineKind::exact,   Marker::none, true};
  Plot plot{
      fmt::format("{}: share of scans that were right", family.family), "", PlotScale::from_zero, {ideal}};
  plot.span = {1.0};
  const auto add = [&](const char* name, const char* colour, const Calibration& calibration) {
    PlotSeries measured{name, colour, {}, {}, LineKind::exact, Marker::circle};
    for (const ReliabilityBin& bin : calibration.bins) {
      if (bin.count == 0) continue;
      measured.x.push_back(bin.forecast_mean);
      measured.y.push_back(bin.observed);
    }
    plot.series.push_back(std::move(measured));
  };
  add("loop", "c1", family.closed.calibration);
  add("bare filter", "c5", family.bare.calibration);
  return render_plot(plot, size_axis(plot, "probability of being right, as it says"));
}

constexpr const char* kStyle = "th{width:22%;overflow-wrap:normal}table.numbers th{width:auto}";

}  // namespace

std::string html_page(const FamiliesReport& report) {
  std::string html = page_head("parloc evaluate: families of drives", report.date, report.command, kStyle);
  if (report.interrupted)
    html += fmt::format("<div class=\"warning\">Interrupted: {} of {} drives.</div>\n", report.drives.size(),
                        report.wanted);
  for (const Table& table : result_tables(report)) html += html_text(table);
  html += "<h2>Seeds in which the loop made it worse</h2>\n" + facts_table(failed_facts(report));
  html += "<h2>What it says, and what is</h2>\n<div class=\"sizes\">";
  if (report.families.size() > 1) html += reliability_plot(report.all);
  for (const FamilySummary& family : report.families) html += reliability_plot(family);
  html += "</div>\n<h2>What was evaluated</h2>\n" + facts_table(origin_facts(report));
  html +=
      "<h2>Times on this machine</h2>\n<p class=\"note\">All else on this page is the same on every "
      "machine.</p>\n" +
      facts_table(time_facts(report));
  return html + "</body></html>\n";
}

}  // namespace parloc::tools::families
