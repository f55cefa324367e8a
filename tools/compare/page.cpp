#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tools/compare/comparison.h"
#include "tools/report/plots/plot.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools::compare {
namespace {

constexpr std::size_t kColumns = 300;  // of a curve
constexpr double kLeast = 1e-4;        // metres or radians: of no interest on a logarithmic axis
constexpr double kMost = 10.0;         // a lost filter's kilometres would squash all else

using Series = std::vector<double> TrackErrors::*;

/// Errors of a filter over the time since the start: the root mean square of the runs that kept their robot,
/// and the worst of all.
struct Curves {
  std::vector<double> rms_time_s, rms, worst_time_s, worst;
};

Curves curves_of(const std::vector<FilterRun>& runs, Series series, double until_s) {
  std::vector<double> squares(kColumns, 0.0), counts(kColumns, 0.0), worst(kColumns, -1.0);
  for (const FilterRun& run : runs) {
    const std::vector<double>& values = run.errors.*series;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double part = (run.errors.stamp_s[k] - run.errors.stamp_s[0]) / until_s;
      if (!(part >= 0.0) || !std::isfinite(values[k])) continue;  // stamps of a log may run backwards
      const std::size_t at =
          std::min(kColumns - 1, static_cast<std::size_t>(part * static_cast<double>(kColumns)));
      worst[at] = std::max(worst[at], std::fabs(values[k]));
      if (run.lost()) continue;
      squares[at] += values[k] * values[k];
      counts[at] += 1.0;
    }
  }
  Curves c;
  for (std::size_t k = 0; k < kColumns; ++k) {
    const double time_s = until_s * (static_cast<double>(k) + 0.5) / static_cast<double>(kColumns);
    if (counts[k] > 0.0) {
      c.rms_time_s.push_back(time_s);
      c.rms.push_back(std::clamp(std::sqrt(squares[k] / counts[k]), kLeast, kMost));
    }
    if (worst[k] < 0.0) continue;
    c.worst_time_s.push_back(time_s);
    c.worst.push_back(std::clamp(worst[k], kLeast, kMost));
  }
  return c;
}

double longest_s(const Comparison& c) {
  double longest = 1.0;
  for (const auto& runs : c.outcome.runs)
    for (const FilterRun& r : runs) longest = std::max(longest, r.driven_s);
  return longest;
}

std::vector<PlotSeries> drawn(const Curves& c, bool several) {
  return {{several ? "worst of all runs" : "a lost run", "c5", c.worst_time_s, c.worst, LineKind::exact},
          {several ? "root mean square of the runs that kept their robot" : "a run that kept its robot", "c1",
           c.rms_time_s, c.rms, LineKind::exact}};
}

/// One plot per filter, all with the same axes.
std::string error_plots(const Comparison& c, Series series, const char* what, const char* unit,
                        std::optional<PlotSeries> limit = {}) {
  const double until_s = longest_s(c);
  const bool several = c.request.seeds > 1;
  std::vector<Curves> all;
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  for (const auto& runs : c.outcome.runs) {
    const Curves& curves = all.emplace_back(curves_of(runs, series, until_s));
    for (const double v : curves.rms) low = std::min(low, v);
    for (const double v : curves.worst) high = std::max(high, v);
  }
  std::string html = fmt::format("<h2>{}, {}</h2>\n", what, unit);
  std::vector<PlotSeries> legend = drawn({}, several);
  if (limit) legend.push_back(*limit);
  html += render_legend(legend);
  if (high >= kMost)
    html += fmt::format("<p class=\"note\">Drawn at {:g} {}: all that is more.</p>\n", kMost, unit);
  html += "<div class=\"sizes\">";
  for (std::size_t k = 0; k < all.size(); ++k) {
    Plot plot{c.request.entries[k].label, "", PlotScale::logarithmic};
    plot.legend = false;
    if (high > 0.0) plot.span = {low, high};
    plot.series = drawn(all[k], several);
    if (limit) plot.series.push_back(*limit);
    html += render_plot(plot, size_axis({until_s}, "s since the start", false, false));
  }
  return html + "</div>\n";
}

PlotSeries lost_limit(const Comparison& c) {
  return {"lost, if it ends above",
          "c6",
          {0.0, longest_s(c)},
          {kLost_m, kLost_m},
          LineKind::exact,
          Marker::none,
          true};
}

/// The first column and `count` others.
Table narrowed(const Table& t, std::size_t first, std::size_t count) {
  Table part;
  const auto taken = [&](const auto& all) {
    auto some = all;
    some.assign(all.begin() + static_cast<std::ptrdiff_t>(first),
                all.begin() + static_cast<std::ptrdiff_t>(first + count));
    some.insert(some.begin(), all.front());
    return some;
  };
  part.columns = taken(t.columns);
  for (const auto& row : t.rows) part.rows.push_back(taken(row));
  return part;
}

/// In two parts: a window has no room for all columns side by side.
std::string error_tables(const Comparison& c) {
  const Table all = error_table(c);
  const auto heading = std::find_if(all.columns.begin(), all.columns.end(),
                                    [](const Column& column) { return column.group == "heading, rad"; });
  const auto first = static_cast<std::size_t>(heading - all.columns.begin());
  Table position = narrowed(all, 1, first - 1);
  position.title = all.title;
  return html_text(position) + html_text(narrowed(all, first, all.columns.size() - first));
}

constexpr const char* kStyle = "th{width:22%;overflow-wrap:normal}table.numbers th{width:auto}";

}  // namespace

std::string html_page(const Comparison& c) {
  const std::string title = "parloc compare";
  std::string html = page_head(title, c.date, c.command, kStyle);
  if (c.interrupted)
    html += fmt::format("<div class=\"warning\">Interrupted: {} of {} runs.</div>\n", c.outcome.finished,
                        c.request.seeds * c.request.entries.size());
  html += error_tables(c) + html_text(time_table(c));
  html += error_plots(c, &TrackErrors::position_error_m, "Position errors", "m", lost_limit(c));
  html += error_plots(c, &TrackErrors::heading_error_rad, "Heading errors", "rad");
  html += "<h2>What was compared</h2>\n" + facts_table(origin_facts(c)) + "<h2>Where it ran</h2>\n" +
          facts_table(machine_facts(c));
  return html + "</body></html>\n";
}

}  // namespace parloc::tools::compare
