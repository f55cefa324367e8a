#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "tools/compare/comparison.h"
#include "tools/report/machine/machine.h"
#include "tools/report/result_parts.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools::compare {
namespace {

template <class Value>
MeanDeviation over(const std::vector<const FilterRun*>& runs, Value value) {
  std::vector<double> values;
  for (const FilterRun* r : runs) values.push_back(value(*r));
  return mean_deviation(values);
}

constexpr std::size_t kWidth = 118;

std::string spread(const MeanDeviation& v, int decimals) {
  if (!std::isfinite(v.deviation)) return fixed_text(v.mean, decimals);
  return fmt::format("{:.{}f} +- {:.{}f}", v.mean, decimals, v.deviation, decimals);
}
std::string number(const std::optional<double>& value, int decimals) {
  return value ? fixed_text(*value, decimals) : "-";
}

/// The authors' figures for this filter: as many cells as published_columns().
std::vector<std::string> published_cells(const PublishedSetting& setting, const Entry& e) {
  const PublishedRow* row = find_row(setting, e.kind, e.config.particles);
  if (row == nullptr) return {"-", "-", "-", "-"};
  return {number(row->position_rmse_m, 4), number(row->position_mae_m, 4), number(row->heading_rmse_rad, 4),
          number(row->heading_mae_rad, 4)};
}

std::string kidnapping_text(const Kidnapping& k) {
  const std::string when = k.until_s > k.after_s
                               ? fmt::format("after {:g} to {:g} s, by the seed", k.after_s, k.until_s)
                               : fmt::format("after {:g} s", k.after_s);
  return fmt::format("{}, along its path to {:g} m from where it was", when, k.distance_m);
}

}  // namespace

MeanDeviation mean_deviation(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double v : values) sum += v;
  const double mean = sum / n;  // none: 0 / 0 is NaN, as it should be
  for (const double v : values) squares += (v - mean) * (v - mean);
  return {mean,
          values.size() > 1 ? std::sqrt(squares / (n - 1.0)) : std::numeric_limits<double>::quiet_NaN()};
}

Summary summarise(const std::vector<FilterRun>& runs) {
  Summary s;
  s.runs = runs.size();
  std::vector<const FilterRun*> all, kept, lost;
  for (const FilterRun& r : runs) {
    all.push_back(&r);
    (r.lost() ? lost : kept).push_back(&r);
  }
  s.lost = lost.size();
  s.position_rmse_m = over(kept, [](const FilterRun& r) { return r.errors.position_rmse_m; });
  s.position_mae_m = over(kept, [](const FilterRun& r) { return r.errors.position_mae_m; });
  s.position_max_m = over(kept, [](const FilterRun& r) { return r.errors.position_max_m; });
  s.heading_rmse_rad = over(kept, [](const FilterRun& r) { return r.errors.heading_rmse_rad; });
  s.heading_mae_rad = over(kept, [](const FilterRun& r) { return r.errors.heading_mae_rad; });
  s.heading_max_rad = over(kept, [](const FilterRun& r) { return r.errors.heading_max_rad; });
  s.nees = over(kept, [](const FilterRun& r) { return r.nees; });
  s.lost_s = over(lost, [](const FilterRun& r) { return r.lost_s.value(); });
  s.away = over(all, [](const FilterRun& r) { return r.away; }).mean;
  s.particles = over(all, [](const FilterRun& r) { return r.particles; }).mean;
  std::vector<double> steps;
  double scans = 0.0, skipped = 0.0, driven_s = 0.0, working_s = 0.0;
  for (const FilterRun& r : runs) {
    scans += static_cast<double>(r.scans);
    skipped += static_cast<double>(r.skipped);
    driven_s += r.driven_s;
    working_s += r.working_s;
    steps.insert(steps.end(), r.step_s.begin(), r.step_s.end());
  }
  s.skipped = skipped / scans;
  s.real_time_factor = driven_s / working_s;
  s.step = summarise_times(std::move(steps));
  return s;
}

Facts origin_facts(const Comparison& c) {
  const StartPlan& start = c.request.start;
  Facts lines{{"drives", c.source}, {"map", c.map_path}};
  add_fact(lines, "seeds", "{} from {}{}", c.request.seeds, c.request.first_seed,
           c.interrupted ? "; interrupted, the runs that were finished count" : "");
  std::string told = fmt::format("spread {:g} m, {:g} rad", start.sigma_xy_m, start.sigma_theta_rad);
  if (start.off_m > 0.0 || start.off_rad > 0.0)
    told += fmt::format("; it is wrong by {:g} m and {:g} degrees", start.off_m,
                        start.off_rad * 180.0 / 3.14159265358979);
  lines.push_back({"start", told});
  if (c.plan.kidnapping) lines.push_back({"kidnapped", kidnapping_text(*c.plan.kidnapping)});
  if (c.outcome.unmapped > 0)
    add_fact(lines, "clutter", "{:.1f} % of the hits are on things that are not on the map",
             100.0 * static_cast<double>(c.outcome.unmapped) / static_cast<double>(c.outcome.hits));
  if (c.published != nullptr) lines.push_back({"published", c.published->source});
  add_fact(lines, "lost",
           "farther than {0:g} m off at the end; '> {0:g} m': share of all scans "
           "at which a run was so far off, lost or not",
           kLost_m);
  lines.push_back({"build", version_text()});
  return lines;
}

Facts machine_facts(const Comparison& c) {
  Facts lines{{"machine", fmt::format("{}, {} core{}", c.machine.cpu, c.machine.cores,
                                      c.machine.cores == 1 ? "" : "s")}};
  if (c.shards > 0) {
    lines.push_back({"times", "of the machines that computed the shards; whole work " +
                                  work_text(c.wall_s, c.request.jobs, c.shards)});
    return lines;
  }
  std::string how = c.request.jobs == 1 ? std::string("one filter at a time, each in one thread")
                                        : fmt::format("{} at once, which disturb each other", c.request.jobs);
  lines.push_back({"times", how + fmt::format("; whole work {:.1f} s", c.wall_s)});
  return lines;
}

Table error_table(const Comparison& c) {
  Table t;
  t.title = "Errors: mean +- standard deviation of the runs that kept their robot";
  t.columns = {{"", "filter", true},
               {"", "runs"},
               {"", "lost"},
               {"", fmt::format("> {:g} m", kLost_m)},
               {"position, m", "RMSE"},
               {"position, m", "MAE"},
               {"position, m", "max"},
               {"heading, rad", "RMSE"},
               {"heading, rad", "MAE"},
               {"heading, rad", "max"},
               {"", "NEES"}};
  if (c.published != nullptr)
    for (const char* name : {"RMSE m", "MAE m", "RMSE rad", "MAE rad"})
      t.columns.push_back({"published", name});
  for (std::size_t k = 0; k < c.summaries.size(); ++k) {
    const Summary& s = c.summaries[k];
    auto& row = t.rows.emplace_back();
    row = {c.request.entries[k].label,
           std::to_string(s.runs),
           std::to_string(s.lost),
           percent_text(s.away),
           spread(s.position_rmse_m, 4),
           spread(s.position_mae_m, 4),
           spread(s.position_max_m, 3),
           spread(s.heading_rmse_rad, 4),
           spread(s.heading_mae_rad, 4),
           spread(s.heading_max_rad, 3),
           spread(s.nees, 1)};
    if (c.published == nullptr) continue;
    for (std::string& cell : published_cells(*c.published, c.request.entries[k]))
      row.push_back(std::move(cell));
  }
  return t;
}

Table time_table(const Comparison& c) {
  Table t;
  t.title = "Times on this machine: of a step that takes its scan in, and of all steps together";
  t.columns = {{"", "filter", true}, {"", "particles"},     {"", "median ms"},    {"", "p99 ms"},
               {"", "x real time"},  {"", "scans skipped"}, {"", "backend", true}};
  for (std::size_t k = 0; k < c.summaries.size(); ++k) {
    const Summary& s = c.summaries[k];
    const bool timed = s.step.count > 0;
    t.rows.push_back({c.request.entries[k].label, s.particles > 0.0 ? fixed_text(s.particles, 0) : "-",
                      timed ? milliseconds_text(s.step.median_s) : "-",
                      timed ? milliseconds_text(s.step.p99_s) : "-", significant(s.real_time_factor, 3),
                      percent_text(s.skipped), c.outcome.backends[k].empty() ? "-" : c.outcome.backends[k]});
  }
  return t;
}

std::string terminal_text(const Comparison& c) {
  constexpr std::size_t kNames = 12;
  return aligned_text(origin_facts(c), kNames) + "\n" + terminal_text(error_table(c), kWidth) + "\n" +
         terminal_text(time_table(c), kWidth) + "\n" + aligned_text(machine_facts(c), kNames);
}

std::string markdown_text(const Comparison& c) {
  std::string text = fmt::format("# Filters compared\n\n```\n{}\n```\n\n{}.\n\n", c.command, c.date);
  text += markdown_list(origin_facts(c)) + "\n" + markdown_text(error_table(c)) + "\n" +
          markdown_text(time_table(c)) + "\n";
  return text + markdown_list(machine_facts(c));
}

}  // namespace parloc::tools::compare
