#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "common/model/model_settings.h"
#include "tools/bench/forms.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools::bench {
namespace {

/// Marks what is within the budget; a blank keeps the others in line.
std::string marked(const std::string& text, double seconds) {
  return text + (seconds <= kBudget_s ? "*" : " ");
}

/// A place in at most 9 characters.
std::string short_place(const Variant& v) {
  return v.backend == BackendChoice::cpu && v.threads >= 10 ? fmt::format("{} thr.", v.threads) : place_of(v);
}

std::string group_of(const Variant& v) {
  return kAlgorithmNames[static_cast<std::size_t>(v.algorithm)] +
         std::string(v.backend == BackendChoice::cuda ? ", GPU" : "");
}

/// Sizes of the published tables that were measured with any variant.
std::vector<std::pair<std::int64_t, int>> measured_sizes(const Results& results, const Place& place) {
  std::vector<std::pair<std::int64_t, int>> sizes;
  for (const std::int64_t n : kPublishedParticles) {
    for (const int m : kPublishedBeams) {
      const bool any = std::any_of(results.rows.begin(), results.rows.end(), [&](const Row& row) {
        return row.sweep == Sweep::tables && row.place == place && row.particles == n && row.beams == m;
      });
      if (any) sizes.emplace_back(n, m);
    }
  }
  return sizes;
}

std::vector<std::string> time_cells(const Row& row) {
  const TimeSummary& t = row.time;
  return {milliseconds_text(t.median_s), milliseconds_text(t.q1_s), milliseconds_text(t.q3_s),
          milliseconds_text(t.p99_s),    std::to_string(t.count),   short_number(row.rays_per_s())};
}

std::vector<Column> time_columns(const std::string& group) {
  return {{group, "median"}, {group, "q1"}, {group, "q3"}, {group, "p99"}, {"", "steps"}, {"", "rays/s"}};
}

void append(std::vector<std::string>& cells, const std::vector<std::string>& more) {
  cells.insert(cells.end(), more.begin(), more.end());
}

/// `paz2012` on one thread, against which the others are compared; null if it was not measured.
const Row* baseline(const Results& results, const Place& place, std::int64_t particles, int beams) {
  for (std::size_t v = 0; v < results.variants.size(); ++v) {
    if (results.variants[v] == Variant{Algorithm::paz2012, BackendChoice::cpu, 1, 0})
      return results.find(Sweep::tables, place, v, particles, beams);
  }
  return nullptr;
}

/// Bytes that a step must move at least, per second.
double least_bytes_per_s(const Row& row) {
  const auto bytes = least_stage_bytes(row.particles, row.beams);
  return std::accumulate(bytes.begin(), bytes.end(), 0.0) / row.time.median_s;
}

}  // namespace

Table published_table(const Results& results, const Place& place, const PublishedTable& published) {
  Table table;
  table.title = fmt::format("Published for: {} [s]", published.machine);
  table.columns = {{"", "size", true}, {"", "2012"}};
  table.keys = 2;
  const std::vector<std::size_t> variants = results.variants_of(Sweep::tables, place);
  for (const std::size_t v : variants) {
    const std::string group = group_of(results.variants[v]);
    table.columns.push_back({group, short_place(results.variants[v])});
    table.columns.push_back({group, "ratio"});
  }
  for (const auto& [particles, beams] : measured_sizes(results, place)) {
    const double then_s = published_seconds(published, particles, beams).value_or(0.0);
    std::vector<std::string> cells{size_text(particles, beams),
                                   marked(fmt::format("{:.4f}", then_s), then_s)};
    for (const std::size_t v : variants) {
      const Row* row = results.find(Sweep::tables, place, v, particles, beams);
      cells.push_back(row != nullptr ? marked(seconds_text(row->time.median_s), row->time.median_s) : "- ");
      cells.push_back(row != nullptr ? significant(row->time.median_s / then_s, 2) : "-");
    }
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table summary_table(const Results& results, const Place& place) {
  Table table;
  const auto sizes = measured_sizes(results, place);
  if (sizes.empty()) return table;
  const auto [particles, beams] = sizes.back();
  const std::string group = size_text(particles, beams) + " [ms]";
  table.columns = {{"", "", true}, {"", "in 40 ms"}};
  for (const Column& c : time_columns(group)) table.columns.push_back(c);
  table.columns.push_back({"", "speed-up"});
  for (const PublishedTable& p : published_tables()) {
    const auto within = std::count_if(sizes.begin(), sizes.end(), [&p = p](const auto& size) {
      return published_seconds(p, size.first, size.second) <= kBudget_s;
    });
    const double then_s = published_seconds(p, particles, beams).value_or(0.0);
    const double rays_per_s = static_cast<double>(particles) * beams / then_s;
    table.rows.push_back({std::string("2012: ") + p.machine, fmt::format("{} of {}", within, sizes.size()),
                          milliseconds_text(then_s), "", "", "", "", short_number(rays_per_s), ""});
  }
  const Row* base = baseline(results, place, particles, beams);
  for (const std::size_t v : results.variants_of(Sweep::tables, place)) {
    const auto within = std::count_if(results.rows.begin(), results.rows.end(), [&](const Row& row) {
      return row.sweep == Sweep::tables && row.place == place && row.variant == v &&
             row.time.median_s <= kBudget_s;
    });
    std::vector<std::string> cells{name_of(results.variants[v]),
                                   fmt::format("{} of {}", within, sizes.size())};
    const Row* row = results.find(Sweep::tables, place, v, particles, beams);
    append(cells, row != nullptr ? time_cells(*row) : std::vector<std::string>(6, "-"));
    const bool comparable = row != nullptr && base != nullptr;
    cells.push_back(comparable ? significant(base->time.median_s / row->time.median_s, 3) + " x" : "-");
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table peers_table(const Results& results, const Place& place) {
  Table table;
  table.title = fmt::format("Other programs on {}, parloc on this machine: {} [ms]", kPeerMachine,
                            size_text(kPeerParticles, kPeerBeams));
  table.columns = {{"", "model", true}, {"", "program", true}, {"", "threads"},
                   {"", "there"},       {"", "parloc, here"},  {"", "ratio"}};
  table.keys = 3;
  for (const PeerTime& peer : peer_times())
    for (const Row& row : results.rows) {
      const Variant& v = results.variants[row.variant];
      if (row.sweep != Sweep::peers || !(row.place == place) || v.model != peer.model ||
          v.threads != peer.threads)
        continue;
      table.rows.push_back({std::string(name_of(peer.model, kSensorModels)), peer.program,
                            std::to_string(peer.threads), milliseconds_text(peer.seconds),
                            milliseconds_text(row.time.median_s),
                            significant(peer.seconds / row.time.median_s, 3) + " x"});
    }
  return table;
}

Table detail_table(const Results& results, const Place& place, Sweep sweep) {
  Table table;
  table.columns = {{"", "size", true}, {"", "variant", true}};
  table.keys = 2;
  for (const Column& c : time_columns("one step [ms]")) table.columns.push_back(c);
  table.columns.push_back({"", "bytes/s"});
  for (const Row& row : results.rows) {
    if (row.sweep != sweep || !(row.place == place)) continue;
    std::vector<std::string> cells{size_text(row.particles, row.beams),
                                   name_of(results.variants[row.variant])};
    append(cells, time_cells(row));
    cells.push_back(short_number(least_bytes_per_s(row)));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

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
