#include "tools/bench/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tools/bench/published.h"
#include "tools/bench/scale_run.h"
#include "tools/report/plots/xy_plot.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools::bench {
namespace {

constexpr std::array<Marker, 4> kMarkers{Marker::circle, Marker::square, Marker::triangle, Marker::diamond};

/// An empty curve in the style of the variant: the colour says what, the marker where.
Curve curve_of(const Results& results, std::size_t variant) {
  const Variant& v = results.variants[variant];
  Curve c;
  c.label = name_of(v);
  c.colour = v.backend == BackendChoice::cuda ? "c4" : v.algorithm == Algorithm::parloc ? "c1" : "c2";
  const bool many = v.backend == BackendChoice::cuda ? v.device > 0 : v.threads > 1;
  c.marker = v.backend == BackendChoice::cuda ? kMarkers[static_cast<std::size_t>(2 + (many ? 1 : 0))]
                                              : kMarkers[many ? 1 : 0];
  return c;
}

std::vector<Curve> published_curves(int beams) {
  const std::array<const char*, 3> colours{"c6", "c3", "c5"};
  std::vector<Curve> curves;
  for (const PublishedTable& t : published_tables()) {
    Curve c;
    c.label = std::string("2012: ") + t.machine;
    c.colour = colours[curves.size()];
    c.marker = kMarkers[curves.size()];
    c.dashed = true;
    for (const std::int64_t n : kPublishedParticles) {
      c.x.push_back(static_cast<double>(n));
      c.y.push_back(*published_seconds(t, n, beams));
    }
    curves.push_back(std::move(c));
  }
  return curves;
}

/// Median step over particles or beams, or rays per second.
template <class X, class Y>
std::vector<Curve> measured_curves(const Results& results, const Place& place, Sweep sweep, int beams,
                                   const X& x, const Y& y) {
  std::vector<Curve> curves;
  for (const std::size_t v : results.variants_of(sweep, place)) {
    Curve c = curve_of(results, v);
    for (const Row& row : results.rows) {
      const bool wanted = row.sweep == sweep && row.place == place && row.variant == v;
      if (!wanted || (beams > 0 && row.beams != beams)) continue;
      c.x.push_back(x(row));
      c.y.push_back(y(row));
    }
    curves.push_back(std::move(c));
  }
  return curves;
}

double particles_of(const Row& row) {
  return static_cast<double>(row.particles);
}
double median_of(const Row& row) {
  return row.time.median_s;
}

Level level_of(double budget_s) {
  return {budget_s, fmt::format("{:g} ms", 1e3 * budget_s)};
}

XyPlot particles_plot(const Results& results, const Place& place) {
  XyPlot plot;
  plot.title = "Time of a step";
  plot.x_name = "particles";
  plot.x_logarithmic = true;
  plot.x_ticks = {1e3, 1e4, 1e5, 1e6, 1e7};
  plot.curves = measured_curves(results, place, Sweep::particles, 0, particles_of, median_of);
  for (const double budget_s : kScaleBudgets_s) plot.levels.push_back(level_of(budget_s));
  return plot;
}

XyPlot beams_plot(const Results& results, const Place& place) {
  XyPlot plot;
  plot.title = "Rays per second";
  plot.x_name = "beams";
  plot.unit = YUnit::plain;
  plot.y_logarithmic = false;
  plot.x_ticks = {0, 200, 400, 600, 800, 1000};
  plot.curves = measured_curves(
      results, place, Sweep::beams, 0, [](const Row& row) { return static_cast<double>(row.beams); },
      [](const Row& row) { return row.rays_per_s(); });
  return plot;
}

/// One curve per size; speed over that of one thread.
XyPlot threads_plot(const Results& results, const Place& place, std::vector<Curve>& legend) {
  XyPlot plot;
  plot.title = "Faster than one thread";
  plot.x_name = "threads";
  plot.unit = YUnit::plain;
  plot.y_logarithmic = false;
  const std::array<const char*, 2> colours{"c5", "c1"};
  for (const Row& alone : results.rows) {
    const bool one = alone.sweep == Sweep::threads && alone.place == place &&
                     results.variants[alone.variant].threads == 1 && plot.curves.size() < colours.size();
    if (!one) continue;
    Curve c;
    c.label = fmt::format("{} x {}", alone.particles, alone.beams);
    c.colour = colours[plot.curves.size()];
    c.marker = kMarkers[plot.curves.size()];
    for (const Row& row : results.rows) {
      if (row.sweep != Sweep::threads || !(row.place == place) || row.particles != alone.particles) continue;
      c.x.push_back(results.variants[row.variant].threads);
      c.y.push_back(alone.time.median_s / row.time.median_s);
      if (std::find(plot.x_ticks.begin(), plot.x_ticks.end(), c.x.back()) == plot.x_ticks.end())
        plot.x_ticks.push_back(c.x.back());
    }
    plot.curves.push_back(std::move(c));
  }
  legend = plot.curves;
  return plot;
}

}  // namespace

std::string published_plots(const Results& results, const Place& place) {
  std::vector<XyPlot> plots;
  std::vector<double> span;  // the same axis for all, so that they can be compared
  for (const int beams : kPublishedBeams) {
    XyPlot& plot = plots.emplace_back();
    plot.title = fmt::format("{} beams", beams);
    plot.x_name = "particles";
    plot.x_ticks = {500, 1000, 2000, 3000, 4000};
    plot.curves = published_curves(beams);
    const std::vector<Curve> measured =
        measured_curves(results, place, Sweep::tables, beams, particles_of, median_of);
    plot.curves.insert(plot.curves.end(), measured.begin(), measured.end());
    plot.levels = {level_of(kBudget_s)};
    for (const Curve& c : plot.curves) span.insert(span.end(), c.y.begin(), c.y.end());
  }
  std::string html = "<p class=\"note\">Time of one filter step; dashed: published in 2012.</p>" +
                     render_legend(plots.front().curves) + "<div class=\"xys\">";
  for (XyPlot& plot : plots) {
    plot.y_span = span;
    html += render(plot);
  }
  return html + "</div>\n";
}

std::string scale_plots(const Results& results, const Place& place) {
  const XyPlot particles = particles_plot(results, place);
  std::vector<Curve> thread_curves;
  const XyPlot threads = threads_plot(results, place, thread_curves);
  std::string html = render_legend(particles.curves) + "<div class=\"xys\">" + render(particles) +
                     render(beams_plot(results, place)) + render(threads) + "</div>\n";
  if (!thread_curves.empty())
    html += "<p class=\"note\">Threads, particles x beams:</p>" + render_legend(thread_curves);
  return html;
}

}  // namespace parloc::tools::bench
