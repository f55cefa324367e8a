#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "common/math/angle_units.h"
#include "common/math/quantile.h"
#include "tools/report/plots/plot.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

template <class Get>
std::vector<double> column(const std::vector<StepRecord>& steps, Get get) {
  std::vector<double> values;
  values.reserve(steps.size());
  for (const StepRecord& step : steps) values.push_back(std::invoke(get, step));
  return values;
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& v : values) v *= factor;
  return values;
}

template <class When>
std::vector<double> stamps_when(const std::vector<StepRecord>& steps, When when) {
  std::vector<double> stamps;
  for (const StepRecord& step : steps) {
    if (std::invoke(when, step)) stamps.push_back(step.stamp_s);
  }
  return stamps;
}

Plot position_plot(const TrackErrors& errors) {
  Plot plot{"Position error", "m", PlotScale::automatic};
  plot.series.push_back({"", "c1", errors.stamp_s, errors.position_error_m});
  plot.levels.push_back(
      {"RMSE " + number_text(errors.position_rmse_m, 3) + " m", "c6", errors.position_rmse_m});
  return plot;
}

/// An error around zero, with three standard deviations of the filter's own opinion behind it.
Plot error_plot(const std::string& title, const std::string& unit, const TrackErrors& errors,
                const std::vector<double>& error, const std::vector<StepRecord>& steps,
                const std::vector<double>& sigma) {
  Plot plot{title, unit, PlotScale::symmetric};
  plot.series.push_back({"", "c1", errors.stamp_s, error});
  if (std::any_of(sigma.begin(), sigma.end(), drawable)) {
    plot.bands.push_back(
        {"\xC2\xB1"
         "3 \xCF\x83 of the particles",
         "c4", column(steps, &StepRecord::stamp_s), scaled(sigma, 3)});
  }
  return plot;
}

Plot n_eff_plot(const RunReport& report, const std::vector<double>& stamps) {
  // A number that adapts starts at many times what it is later.
  const PlotScale scale = report.adaptive ? PlotScale::automatic : PlotScale::from_zero;
  Plot plot{"Effective particles", "N_eff", scale};
  plot.series.push_back(
      {report.adaptive ? "N_eff" : "", "c1", stamps, column(report.steps, &StepRecord::n_eff)});
  if (report.adaptive)
    plot.series.push_back({"all particles", "c6", stamps, column(report.steps, &StepRecord::particles)});
  if (report.resample_below > 0.0) plot.levels.push_back({"threshold", "c5", report.resample_below});
  if (report.particles > 0.0) plot.levels.push_back({"all particles", "c6", report.particles});
  plot.marks.push_back({"resampled", "c2", stamps_when(report.steps, &StepRecord::resampled)});
  plot.marks.push_back({"no particle fits", "c5", stamps_when(report.steps, &StepRecord::lost)});
  return plot;
}

/// Empty for a run that was not judged.
Plot health_plot(const RunReport& report, const std::vector<double>& stamps) {
  Plot plot{"Health", "probability of being right", PlotScale::from_zero};
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  plot.series.push_back({"", "c1", stamps, column(report.steps, [&](auto& s) {
                           return s.health ? s.health->probability : unknown;
                         })});
  plot.levels.push_back({"certain", "c6", 1.0});
  const auto mark = [&](const char* label, const char* colour, HealthState state, int row) {
    const auto is_it = [&](auto& s) { return s.health && s.health->state == state; };
    plot.marks.push_back({label, colour, stamps_when(report.steps, is_it), row});
  };
  mark("ambiguous", "c3", HealthState::ambiguous, 1);
  mark("lost", "c5", HealthState::lost, 2);
  plot.marks.push_back({"searched", "c2", stamps_when(report.steps, &StepRecord::searched)});
  return plot;
}

Plot time_plot(const RunReport& report, const std::vector<double>& stamps) {
  Plot plot{"Time per step", "ms", PlotScale::automatic};
  const std::vector<double> times = column(report.steps, &StepRecord::step_ms);
  plot.series.push_back({"", "c1", stamps, times});
  std::vector<double> known;
  std::copy_if(times.begin(), times.end(), std::back_inserter(known), drawable);
  const double middle = nearest_rank(ascending(std::move(known)), 50);
  if (drawable(middle)) plot.levels.push_back({"median " + number_text(middle, 3) + " ms", "c6", middle});
  return plot;
}

}  // namespace

std::vector<Plot> error_plots(const RunReport& report) {
  if (!report.errors || report.errors->compared == 0) return {};
  const TrackErrors& e = *report.errors;
  const auto sigma = [&](double StepRecord::*value) { return column(report.steps, value); };
  return {error_plot("Error in x", "m", e, e.x_error_m, report.steps, sigma(&StepRecord::sigma_x_m)),
          error_plot("Error in y", "m", e, e.y_error_m, report.steps, sigma(&StepRecord::sigma_y_m)),
          error_plot("Error in heading", "degrees", e, scaled(e.heading_error_rad, kDegPerRad), report.steps,
                     scaled(sigma(&StepRecord::sigma_theta_rad), kDegPerRad))};
}

std::string plot_figures(const RunReport& report, const Axis& axis) {
  const std::vector<double> stamps = column(report.steps, &StepRecord::stamp_s);
  const std::vector<double> sigma_x = column(report.steps, &StepRecord::sigma_x_m);
  const std::vector<double> sigma_y = column(report.steps, &StepRecord::sigma_y_m);
  const std::vector<double> sigma_theta =
      scaled(column(report.steps, &StepRecord::sigma_theta_rad), kDegPerRad);
  std::string html;
  if (report.errors) html += render_plot(position_plot(*report.errors), axis);
  for (const Plot& plot : error_plots(report)) html += render_plot(plot, axis);
  if (std::any_of(report.steps.begin(), report.steps.end(), [](auto& s) { return s.health.has_value(); }))
    html += render_plot(health_plot(report, stamps), axis);
  html += render_plot(n_eff_plot(report, stamps), axis);
  for (const Plot& plot : report.plots) html += render_plot(plot, axis);
  html += render_plot({"Standard deviation of position",
                       "m",
                       PlotScale::automatic,
                       {{"x", "c1", stamps, sigma_x}, {"y", "c2", stamps, sigma_y}}},
                      axis);
  html += render_plot(
      {"Standard deviation of heading", "degrees", PlotScale::automatic, {{"", "c1", stamps, sigma_theta}}},
      axis);
  html += render_plot(time_plot(report, stamps), axis);
  return html.empty() ? html : "<h2>How it went</h2>\n<div class=\"plots\">" + html + "</div>\n";
}

}  // namespace parloc::tools
