#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/how_long.h"
#include "tools/report/even_sample.h"
#include "tools/report/map_view.h"
#include "tools/report/plots/plot.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"
#include "tools/report/text/table.h"

namespace parloc::tools::evaluate {
namespace {

constexpr std::int32_t kLeastMap_px = 600, kMostMap_px = 1600;

std::string time_plot(const Evaluation& e) {
  std::vector<double> localized_s, noticed_s;
  e.trials.each([&](const TrialResult& t) {
    if (t.outcome.localized_after_s) localized_s.push_back(*t.outcome.localized_after_s);
    if (t.outcome.noticed_after_s) noticed_s.push_back(*t.outcome.noticed_after_s);
  });
  double until_s = 1.5 * e.limit_s;
  for (const double t : localized_s) until_s = std::max(until_s, 1.05 * t);
  Plot plot{"Trials localized by then", "%", PlotScale::from_zero};
  plot.span = {100.0};
  plot.series.push_back(cumulative_series("localized", "c1", localized_s, e.trials.size(), until_s));
  const bool kidnap = e.plan.task == TrialTask::kidnap;
  if (kidnap) plot.series.push_back(cumulative_series("noticed", "c5", noticed_s, e.trials.size(), until_s));
  plot.series.push_back(upright("limit", "c6", e.limit_s, 0.0, 100.0));
  return render_plot(plot, size_axis(plot, kidnap ? "s since the kidnapping" : "s since the start"));
}

std::string reliability_plot(const Evaluation& e) {
  PlotSeries measured{"measured", "c1", {}, {}, LineKind::exact, Marker::circle};
  for (const ReliabilityBin& bin : e.summary.calibration.bins) {
    if (bin.count == 0) continue;
    measured.x.push_back(bin.forecast_mean);
    measured.y.push_back(bin.observed);
  }
  const PlotSeries ideal{"as it should be", "c6",         {0.0, 1.0}, {0.0, 1.0},
                         LineKind::exact,   Marker::none, true};
  const Plot plot{"Share of scans that were right", "", PlotScale::from_zero, {ideal, measured}};
  return render_plot(plot, size_axis(plot, "probability of being right, as it says"));
}

Table reliability_table(const Evaluation& e) {
  Table table;
  table.title = "Probability of being right";
  table.columns = {{"", "it says", true}, {"", "scans"}, {"", "mean said"}, {"", "was right"}};
  table.rows = reliability_rows(e);
  return table;
}

constexpr std::size_t kMostDots = 2000;  // of each kind: a browser draws more of them slowly

/// Where trials with one outcome started: evenly over all.
struct Starts {
  std::string cls;
  std::size_t all = 0;
  EvenSample<std::pair<std::uint64_t, Pose>> some{kMostDots};

  void offer(const TrialResult& t) {
    if (!drawable_point(t.start.x_m, t.start.y_m)) return;
    ++all;
    some.offer([&] { return std::pair(t.seed, t.start); });
  }
  /// Each with a tip that names its seed.
  std::string dots(const MapView& view) const {
    std::string svg;
    for (const auto& [seed, start] : some.kept()) {
      const Pixel at = view.to_pixel(start.x_m, start.y_m);
      fmt::format_to(std::back_inserter(svg),
                     "<path class=\"{}\" d=\"M{:.1f} {:.1f}h0\"><title>seed {}</title></path>", cls, at.x,
                     at.y, seed);
    }
    return svg;
  }
  std::string name(const char* outcome) const {
    return some.kept().size() == all ? outcome
                                     : fmt::format("{} ({} of {})", outcome, some.kept().size(), all);
  }
};

std::string map_figure(const Evaluation& e, const GridMap& map) {
  RunReport only_map;
  only_map.map = &map;
  const std::optional<MapView> view = fit_view(only_map, kLeastMap_px, kMostMap_px);
  if (!view) return "";
  Starts came{"came c4"}, failed{"failed c5"};
  e.trials.each([&](const TrialResult& t) { (succeeded(t.outcome, e.limit_s) ? came : failed).offer(t); });
  const std::string drawing = map_image(map, *view) + came.dots(*view) + failed.dots(*view);
  return std::string("<h2>Where they started</h2>\n") + invert_filter() + "<figure><figcaption>" +
         legend_key("dot c4", came.name("success")) + legend_key("dot c5", failed.name("failure")) +
         "</figcaption>" + map_frame(*view, "Map with the starts", drawing) + "</figure>\n";
}

constexpr const char* kStyle =
    ".came{stroke-width:7px}.failed{stroke-width:10px}th{width:22%;overflow-wrap:normal}table.numbers "
    "th{width:auto}";

}  // namespace

std::string html_page(const Evaluation& e, const GridMap& map) {
  const std::string title = fmt::format("parloc evaluate: {}", name_of(e.plan.task));
  std::string html = page_head(title, e.date, e.command, kStyle);
  if (e.interrupted)
    html += fmt::format("<div class=\"warning\">Interrupted: {} of {} trials.</div>\n", e.trials.size(),
                        e.wanted);
  html += facts_table(result_facts(e), "summary");
  html += "<h2>How soon, and how honest</h2>\n<div class=\"sizes\">" + time_plot(e) + reliability_plot(e) +
          "</div>\n";
  html += html_text(reliability_table(e));
  html += map_figure(e, map);
  html += "<h2>What was evaluated</h2>\n" + facts_table(origin_facts(e));
  html +=
      "<h2>Times on this machine</h2>\n<p class=\"note\">All else on this page is the same on every "
      "machine.</p>\n" +
      facts_table(time_facts(e)) + html_text(how_long_table(next_trials(e), e.trial_s));
  return html + "</body></html>\n";
}

}  // namespace parloc::tools::evaluate
