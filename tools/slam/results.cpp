#include "tools/slam/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/bench/json_parts.h"
#include "tools/bench/statistics.h"
#include "tools/result_parts.h"

namespace parloc::slam {
namespace {

using Json = nlohmann::ordered_json;

std::size_t resampled(const Mapping& m) {
  return static_cast<std::size_t>(
      std::count_if(m.records.begin(), m.records.end(), [](const SlamRecord& r) { return r.resampled; }));
}

std::string memory_text(const SlamMemory& memory) {
  constexpr double kMiB = 1024.0 * 1024.0;
  return fmt::format("{:.1f} MiB of tiles in use, {:.1f} at most, {:.1f} MiB of tables",
                     static_cast<double>(memory.tile_bytes) / kMiB,
                     static_cast<double>(memory.most_tile_bytes) / kMiB,
                     static_cast<double>(memory.table_bytes) / kMiB);
}

/// How many scans ago all particles of the end were one.
std::string depletion_text(const Mapping& m) {
  const auto several =
      std::find_if(m.distinct.begin(), m.distinct.end(), [](std::size_t n) { return n > 1; });
  const auto single = static_cast<std::size_t>(several - m.distinct.begin());
  return fmt::format("the particles of the end share one way for the first {} of {} scans", single,
                     m.distinct.size());
}

std::vector<Fact> main_facts(const SlamResults& results) {
  const Mapping& m = results.mapping;
  std::vector<Fact> facts;
  facts.push_back({"scans", fmt::format("{} read, {} taken in{}", m.scans, m.records.size(),
                                        m.interrupted ? " (interrupted)" : "")});
  facts.push_back(
      {"map", fmt::format("{} x {} cells of {} m", m.map.width, m.map.height, m.map.resolution_m)});
  if (results.relations && results.relations->compared > 0)
    facts.push_back({"relation error", tools::relations_text(*results.relations)});
  facts.push_back({"particles", fmt::format("{}, resampled {} times; {}", m.config.slam.particles,
                                            resampled(m), depletion_text(m))});
  facts.push_back({"memory", memory_text(m.memory)});
  facts.push_back({"time", fmt::format("{:.2f} s for {:.2f} s of log ({:.1f} times real time)", m.wall_s,
                                       m.log_s, m.real_time_factor())});
  facts.push_back({"backend", m.backend});
  facts.push_back({"digest", m.digest});
  return facts;
}

std::vector<std::string> warning_lines(const Mapping& m) {
  std::vector<std::string> lines;
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) lines.push_back(fmt::format("{} {}", count, what));
  };
  add(m.warnings.broken_lines, "broken lines were skipped");
  add(m.warnings.backward_stamps, "scans go back in time; the order of the file was kept");
  add(m.warnings.beam_count_changes, "scans have another number of beams than the one before");
  lines.insert(lines.end(), m.warnings.messages.begin(), m.warnings.messages.end());
  return lines;
}

Json memory_json(const SlamMemory& memory) {
  return {{"tile_bytes", memory.tile_bytes},
          {"most_tile_bytes", memory.most_tile_bytes},
          {"table_bytes", memory.table_bytes}};
}

}  // namespace

std::string metrics_json(const SlamResults& results) {
  const Mapping& m = results.mapping;
  Json json;
  json["parloc"] = PARLOC_VERSION;
  json["relations"] = tools::relations_json(results.relations);
  json["scans"] = m.scans;
  json["scans_taken_in"] = m.records.size();
  json["interrupted"] = m.interrupted;
  json["resampled"] = resampled(m);
  json["distinct_ancestors"] = m.distinct;
  json["map"] = {{"width", m.map.width}, {"height", m.map.height}, {"resolution_m", m.map.resolution_m}};
  json["memory"] = memory_json(m.memory);
  json["wall_s"] = m.wall_s;
  json["log_s"] = m.log_s;
  json["real_time_factor"] = m.real_time_factor();
  const bench::TimeSummary step = bench::summarise(m.step_s);
  json["step_ms_median"] = 1e3 * step.median_s;
  json["step_ms_p99"] = 1e3 * step.p99_s;
  json["warnings"] = {{"broken_lines", m.warnings.broken_lines},
                      {"backward_stamps", m.warnings.backward_stamps},
                      {"beam_count_changes", m.warnings.beam_count_changes},
                      {"messages", m.warnings.messages}};
  json["backend"] = m.backend;
  json["seed"] = m.config.seed;
  json["digest"] = m.digest;
  json["log"] = results.log_path;
  json["command"] = results.command_line;
  json["config"] = tools::config_json(m.config);
  return bench::file_text(json);
}

RunReport report_of(const SlamResults& results) {
  const Mapping& m = results.mapping;
  RunReport report;
  report.title = fmt::format("Map of {}", results.log_path);
  report.command_line = results.command_line;
  report.summary = main_facts(results);
  report.details = {tools::config_facts(m.config)};
  report.warnings = warning_lines(m);
  report.map = &m.map;
  report.estimate = m.trajectory;
  report.odometry = m.odometry;
  report.particles = static_cast<double>(m.config.slam.particles);
  report.resample_below = m.config.slam.resample_threshold * report.particles;
  return report;
}

std::string summary_text(const SlamResults& results) {
  std::string text;
  for (const Fact& fact : main_facts(results)) text += fmt::format("{:<16}{}\n", fact.key, fact.value);
  for (const std::string& line : warning_lines(results.mapping))
    text += fmt::format("{:<16}{}\n", "warning", line);
  return text;
}

}  // namespace parloc::slam
