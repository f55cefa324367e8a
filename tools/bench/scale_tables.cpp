#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "tools/bench/tables.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools::bench {
namespace {

void append(std::vector<std::string>& cells, const std::vector<std::string>& more) {
  cells.insert(cells.end(), more.begin(), more.end());
}

}  // namespace

Table stage_table(const Results& results, const Place& place, std::size_t variant) {
  Table table;
  table.title = fmt::format("Stages of {} [ms, and share of the step]", name_of(results.variants[variant]));
  table.columns = {{"", "size", true}};
  for (const char* stage : kStageNames) table.columns.push_back({"", stage});
  for (const Row& row : results.rows) {
    const bool wanted = row.sweep == Sweep::particles || row.sweep == Sweep::beams;
    if (!wanted || !(row.place == place) || row.variant != variant || !row.stages) continue;
    const double sum_s = std::accumulate(row.stages->begin(), row.stages->end(), 0.0);
    std::vector<std::string> cells{size_text(row.particles, row.beams)};
    for (const double stage_s : *row.stages)
      cells.push_back(fmt::format("{} {:3.0f} %", milliseconds_text(stage_s), 100.0 * stage_s / sum_s));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table beams_table(const Results& results, const Place& place) {
  Table table;
  table.title = "Beams";
  table.columns = {{"", "beams"}};
  const std::vector<std::size_t> variants = results.variants_of(Sweep::beams, place);
  std::vector<int> beams;
  std::int64_t particles = 0;
  for (const Row& row : results.rows) {
    if (row.sweep != Sweep::beams || !(row.place == place)) continue;
    if (std::find(beams.begin(), beams.end(), row.beams) == beams.end()) beams.push_back(row.beams);
    particles = row.particles;
  }
  if (particles > 0) table.title = fmt::format("Beams, {} particles", grouped(particles));
  for (const std::size_t v : variants) {
    for (const char* name : {"step [ms]", "p99 [ms]", "rays/s"})
      table.columns.push_back({name_of(results.variants[v]), name});
  }
  for (const int b : beams) {
    std::vector<std::string> cells{std::to_string(b)};
    for (const std::size_t v : variants) {
      const Row* row = results.find(Sweep::beams, place, v, particles, b);
      append(cells, row == nullptr ? std::vector<std::string>(3, "-")
                                   : std::vector<std::string>{milliseconds_text(row->time.median_s),
                                                              milliseconds_text(row->time.p99_s),
                                                              short_number(row->rays_per_s())});
    }
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table threads_table(const Results& results, const Place& place) {
  Table table;
  table.title = "Threads";
  table.columns = {{"", "threads"}};
  std::vector<std::pair<std::int64_t, int>> sizes;
  for (const Row& row : results.rows) {
    const std::pair<std::int64_t, int> size{row.particles, row.beams};
    if (row.sweep == Sweep::threads && row.place == place &&
        std::find(sizes.begin(), sizes.end(), size) == sizes.end())
      sizes.push_back(size);
  }
  for (const auto& [particles, beams] : sizes) {
    for (const char* name : {"step [ms]", "p99 [ms]", "faster than 1 thread"})
      table.columns.push_back({size_text(particles, beams), name});
  }
  const std::size_t one =
      static_cast<std::size_t>(std::find(results.variants.begin(), results.variants.end(),
                                         Variant{Algorithm::parloc, BackendChoice::cpu, 1, 0}) -
                               results.variants.begin());
  for (const std::size_t v : results.variants_of(Sweep::threads, place)) {
    std::vector<std::string> cells{std::to_string(results.variants[v].threads)};
    for (const auto& [particles, beams] : sizes) {
      const Row* row = results.find(Sweep::threads, place, v, particles, beams);
      const Row* alone = results.find(Sweep::threads, place, one, particles, beams);
      cells.push_back(row != nullptr ? milliseconds_text(row->time.median_s) : "-");
      cells.push_back(row != nullptr ? milliseconds_text(row->time.p99_s) : "-");
      const bool comparable = row != nullptr && alone != nullptr;
      cells.push_back(comparable ? significant(alone->time.median_s / row->time.median_s, 3) + " x" : "-");
    }
    table.rows.push_back(std::move(cells));
  }
  std::sort(table.rows.begin(), table.rows.end(),
            [](const auto& a, const auto& b) { return std::stoi(a[0]) < std::stoi(b[0]); });
  return table;
}

Table largest_table(const Results& results, const Place& place) {
  Table table;
  table.title = "The most particles of which the median step is within a budget";
  table.columns = {{"", "variant", true}, {"", "beams"},    {"", "budget"},
                   {"", "particles"},     {"", "p99 [ms]"}, {"", "", true}};
  for (const Largest& l : results.largest) {
    if (!(l.place == place)) continue;
    const bool none = l.particles == 0;
    table.rows.push_back({name_of(results.variants[l.variant]), std::to_string(l.beams),
                          fmt::format("{:g} ms", 1e3 * l.budget_s),
                          none ? fmt::format("< {}", grouped(l.too_many)) : grouped(l.particles),
                          none ? "-" : milliseconds_text(l.p99_s),
                          l.limit.empty() ? "" : fmt::format("not more because of {}", l.limit)});
  }
  return table;
}

}  // namespace parloc::tools::bench
