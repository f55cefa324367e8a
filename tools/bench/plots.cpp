#include "tools/bench/forms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tools/bench/plan.h"
#include "tools/bench/published.h"
#include "tools/report/plots/plot.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools::bench {
namespace {

constexpr std::array<Marker, 4> kMarkers{Marker::circle, Marker::square, Marker::triangle, Marker::diamond};

/// An empty curve in the style of the variant: the colour says what, the marker where.
PlotSeries curve_of(const Results& results, std::size_t variant) {
  const Variant& v = results.variants[variant];
  PlotSeries c;
  c.label = name_of(v);
  c.colour = v.backend == BackendChoice::cuda ? "c4" : v.algorithm == Algorithm::parloc ? "c1" : "c2";
  const bool many = v.backend == BackendChoice::cuda ? v.device > 0 : v.threads > 1;
  c.marker = v.backend == BackendChoice::cuda ? kMarkers[static_cast<std::size_t>(2 + (many ? 1 : 0))]
                                              : kMarkers[many ? 1 : 0];
  return c;
}

std::vector<PlotSeries> published_curves(int beams) {
  const std::array<const char*, 3> colours{"c6", "c3", "c5"};
  std::vector<PlotSeries> curves;
  for (const PublishedTable& t : published_tables()) {
    PlotSeries c;
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
std::vector<PlotSeries> measured_curves(const Results& results, const Place& place, Sweep sweep, int beams,
                                        const X& x, const Y& y) {
  std::vector<PlotSeries> curves;
  for (const std::size_t v : results.variants_of(sweep, place)) {
    PlotSeries c = curve_of(results, v);
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

PlotLevel level_of(double budget_s) {
  return {fmt::format("{:g} ms", 1e3 * budget_s), "c6", budget_s, true};
}

Plot particles_plot(const Results& results, const Place& place) {
  Plot plot{"Time of a step", "", PlotScale::logarithmic};
  plot.text = TickText::seconds;
  plot.legend = false;
  plot.series = measured_curves(results, place, Sweep::particles, 0, particles_of, median_of);
  for (const double budget_s : kScaleBudgets_s) plot.levels.push_back(level_of(budget_s));
  return plot;
}

Plot beams_plot(const Results& results, const Place& place) {
  Plot plot{"Rays per second", "", PlotScale::from_zero};
  plot.legend = false;
  plot.series = measured_curves(
      results, place, Sweep::beams, 0, [](const Row& row) { return static_cast<double>(row.beams); },
      [](const Row& row) { return row.rays_per_s(); });
  return plot;
}

/// One curve per size; speed over that of one thread.
Plot threads_plot(const Results& results, const Place& place, std::vector<double>& counts) {
  Plot plot{"Faster than one thread", "", PlotScale::from_zero};
  plot.legend = false;
  const std::array<const char*, 2> colours{"c5", "c1"};
  for (const Row& alone : results.rows) {
    const bool one = alone.sweep == Sweep::threads && alone.place == place &&
                     results.variants[alone.variant].threads == 1 && plot.series.size() < colours.size();
    if (!one) continue;
    PlotSeries c;
    c.label = fmt::format("{} x {}", alone.particles, alone.beams);
    c.colour = colours[plot.series.size()];
    c.marker = kMarkers[plot.series.size()];
    for (const Row& row : results.rows) {
      if (row.sweep != Sweep::threads || !(row.place == place) || row.particles != alone.particles) continue;
      c.x.push_back(results.variants[row.variant].threads);
      c.y.push_back(alone.time.median_s / row.time.median_s);
      if (std::find(counts.begin(), counts.end(), c.x.back()) == counts.end()) counts.push_back(c.x.back());
    }
    plot.series.push_back(std::move(c));
  }
  return plot;
}

}  // namespace

std::string published_plots(const Results& results, const Place& place) {
  std::vector<Plot> plots;
  std::vector<double> span;  // the same axis for all, so that they can be compared
  for (const int beams : kPublishedBeams) {
    Plot& plot = plots.emplace_back(Plot{fmt::format("{} beams", beams), "", PlotScale::logarithmic});
    plot.text = TickText::seconds;
    plot.legend = false;
    plot.series = published_curves(beams);
    const std::vector<PlotSeries> measured =
        measured_curves(results, place, Sweep::tables, beams, particles_of, median_of);
    plot.series.insert(plot.series.end(), measured.begin(), measured.end());
    plot.levels = {level_of(kBudget_s)};
    for (const PlotSeries& c : plot.series) span.insert(span.end(), c.y.begin(), c.y.end());
  }
  std::string html = "<p class=\"note\">Time of one filter step; dashed: published in 2012.</p>" +
                     render_legend(plots.front().series) + "<div class=\"sizes\">";
  for (Plot& plot : plots) {
    plot.span = span;
    Axis particles = size_axis(plot, "particles");
    particles.labelled = {500, 1000, 2000, 3000, 4000};
    html += render_plot(plot, particles);
  }
  return html + "</div>\n";
}

std::string scale_plots(const Results& results, const Place& place) {
  const Plot particles = particles_plot(results, place), beams = beams_plot(results, place);
  std::vector<double> counts;
  const Plot threads = threads_plot(results, place, counts);
  Axis thread_axis = size_axis(threads, "threads");
  thread_axis.labelled = counts;
  std::string html = render_legend(particles.series) + "<div class=\"sizes\">" +
                     render_plot(particles, size_axis(particles, "particles", true)) +
                     render_plot(beams, size_axis(beams, "beams")) + render_plot(threads, thread_axis) +
                     "</div>\n";
  if (!threads.series.empty())
    html += "<p class=\"note\">Threads, particles x beams:</p>" + render_legend(threads.series);
  return html;
}

}  // namespace parloc::tools::bench
