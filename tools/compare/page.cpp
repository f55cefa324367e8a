#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/io/html_text.h"
#include "common/io/report_parts.h"
#include "tools/bench/xy_plot.h"
#include "tools/compare/comparison.h"

namespace parloc::compare {
namespace {

constexpr std::size_t kColumns = 300;  // of a curve
constexpr double kLeast_m = 1e-4;      // below it a logarithmic axis is of no interest

using Series = std::vector<double> TrackErrors::*;

/// Whole multiples of 1, 2 or 5 times a power of ten: about five of them.
std::vector<double> ticks_to(double most) {
  const double decade = std::pow(10.0, std::floor(std::log10(most / 4)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * decade * 6 >= most) step = factor * decade;
  std::vector<double> ticks;
  for (int k = 0; k * step <= most * 1.0001; ++k) ticks.push_back(k * step);
  return ticks;
}

/// Errors of all runs of a filter over the time since the start: their root mean square, and the worst.
struct Curves {
  std::vector<double> time_s, rms, worst;
};

Curves curves_of(const std::vector<FilterRun>& runs, Series series, double until_s) {
  std::vector<double> squares(kColumns, 0.0), counts(kColumns, 0.0), worst(kColumns, 0.0);
  for (const FilterRun& run : runs) {
    const std::vector<double>& values = run.errors.*series;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double part = (run.errors.stamp_s[k] - run.errors.stamp_s[0]) / until_s;
      if (!(part >= 0.0) || !std::isfinite(values[k])) continue;  // stamps of a log may run backwards
      const std::size_t at =
          std::min(kColumns - 1, static_cast<std::size_t>(part * static_cast<double>(kColumns)));
      squares[at] += values[k] * values[k];
      counts[at] += 1.0;
      worst[at] = std::max(worst[at], std::fabs(values[k]));
    }
  }
  Curves c;
  for (std::size_t k = 0; k < kColumns; ++k) {
    if (counts[k] == 0.0) continue;
    c.time_s.push_back(until_s * (static_cast<double>(k) + 0.5) / static_cast<double>(kColumns));
    c.rms.push_back(std::max(kLeast_m, std::sqrt(squares[k] / counts[k])));
    c.worst.push_back(std::max(kLeast_m, worst[k]));
  }
  return c;
}

double longest_s(const Comparison& c) {
  double longest = 1.0;
  for (const auto& runs : c.outcome.runs)
    for (const FilterRun& r : runs) longest = std::max(longest, r.driven_s);
  return longest;
}

std::vector<bench::Curve> drawn(const Curves& c, bool several) {
  std::vector<bench::Curve> curves;
  if (several) curves.push_back({"worst run", "c5", bench::Marker::circle, false, c.time_s, c.worst, false});
  curves.push_back({several ? "root mean square over the runs" : "error", "c1", bench::Marker::circle, false,
                    c.time_s, c.rms, false});
  return curves;
}

/// One plot per filter, all with the same axes.
std::string error_plots(const Comparison& c, Series series, const char* what) {
  const double until_s = longest_s(c);
  const bool several = c.request.seeds > 1;
  std::vector<Curves> all;
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  for (const auto& runs : c.outcome.runs) {
    const Curves& curves = all.emplace_back(curves_of(runs, series, until_s));
    for (const double v : curves.rms) low = std::min(low, v);
    for (const double v : curves.worst) high = std::max(high, v);
  }
  std::string html = fmt::format("<h2>{}</h2>\n", what);
  if (!all.empty()) html += bench::render_legend(drawn(all[0], several));
  html += "<div class=\"xys\">";
  for (std::size_t k = 0; k < all.size(); ++k) {
    bench::XyPlot plot;
    plot.title = c.request.entries[k].label;
    plot.x_name = "s since the start";
    plot.unit = bench::YUnit::plain;
    plot.x_ticks = ticks_to(until_s);
    if (high > 0.0) plot.y_span = {low, high};
    plot.curves = drawn(all[k], several);
    html += bench::render(plot);
  }
  return html + "</div>\n";
}

std::string facts_table(const Lines& lines) {
  std::string html = "<table>";
  for (const auto& [name, value] : lines)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>", escape_html(name), escape_html(value));
  return html + "</table>\n";
}

constexpr const char* kStyle = "th{width:22%;overflow-wrap:normal}table.numbers th{width:auto}";

}  // namespace

std::string html_page(const Comparison& c) {
  const std::string title = "parloc compare";
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>{}</title><style>{}{}{}</style></head><body>\n"
      "<h1>{}</h1>\n<p class=\"note\">{}</p><code>{}</code>\n",
      title, report_style(), bench::bench_style(), kStyle, title, escape_html(c.date),
      escape_html(c.command));
  if (c.interrupted)
    html += fmt::format("<div class=\"warning\">Interrupted: {} of {} runs.</div>\n", c.outcome.finished,
                        c.request.seeds * c.request.entries.size());
  html += bench::html_text(error_table(c)) + bench::html_text(time_table(c));
  html += error_plots(c, &TrackErrors::position_error_m, "Position errors, m");
  html += error_plots(c, &TrackErrors::heading_error_rad, "Heading errors, rad");
  html += "<h2>What was compared</h2>\n" + facts_table(origin_lines(c));
  return html + "</body></html>\n";
}

}  // namespace parloc::compare
