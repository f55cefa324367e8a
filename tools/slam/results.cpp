#include "tools/slam/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "common/eval/align.h"
#include "common/io/log_notes.h"
#include "common/math/angle_units.h"
#include "common/slam/matching/tiles.h"
#include "tools/report/machine/statistics.h"
#include "tools/report/result_parts.h"
#include "tools/slam/log_oddities.h"

namespace parloc::tools::slam {
namespace {

constexpr double kMiB = 1024.0 * 1024.0;

std::string memory_text(const Mapping& m) {
  const SlamMemory& memory = m.memory;
  std::string text = fmt::format("{:.1f} MiB of tiles in use, {:.1f} at most, {:.1f} MiB of tables",
                                 static_cast<double>(memory.tile_bytes) / kMiB,
                                 static_cast<double>(memory.most_tile_bytes) / kMiB,
                                 static_cast<double>(memory.table_bytes) / kMiB);
  if (memory.sub_map_bytes > 0)
    text += fmt::format(", {:.1f} MiB handed over", static_cast<double>(memory.sub_map_bytes) / kMiB);
  if (m.resident_bytes)
    text += fmt::format("; the program {:.0f} MiB at most", static_cast<double>(*m.resident_bytes) / kMiB);
  return text;
}

/// How many scans ago all particles of the end were one.
std::string depletion_text(const Mapping& m) {
  const auto several =
      std::find_if(m.distinct.begin(), m.distinct.end(), [](std::size_t n) { return n > 1; });
  const auto single = static_cast<std::size_t>(several - m.distinct.begin());
  return fmt::format("the particles of the end share one way for the first {} of {} scans", single,
                     m.distinct.size());
}

std::string odometry_text(const ScanOdometryCounts& c) {
  return fmt::format("from the scans; {} of {} did not fit, the local map was begun anew {} times", c.unfit,
                     c.scans, c.new_maps);
}

Json odometry_json(const SlamResults& results) {
  const auto& c = results.mapping.scan_odometry;
  if (!c) return {{"from", "recorded"}};
  return {{"from", "scans"},   {"recorded_never_moves", results.mapping.odometry_chosen},
          {"scans", c->scans}, {"unfit", c->unfit},
          {"far", c->far},     {"new_maps", c->new_maps}};
}

std::string loops_text(const LoopCounts& c) {
  return fmt::format("{} matches tried, {} found, {} used; the way was moved by up to {:.2f} m", c.tried,
                     c.found, c.used, c.most_moved_m);
}

Json loops_json(const std::optional<LoopCounts>& c) {
  if (!c) return nullptr;
  return {{"tried", c->tried},
          {"found", c->found},
          {"used", c->used},
          {"refused", c->found - c->used},
          {"most_moved_m", c->most_moved_m}};
}

Facts main_facts(const SlamResults& results) {
  const Mapping& m = results.mapping;
  Facts facts;
  add_fact(facts, "scans", "{} read, {} taken in{}{}", m.scans, m.records.size(),
           m.resumed_at > 0 ? fmt::format(", resumed after {}", m.resumed_at) : "",
           m.interrupted ? " (interrupted)" : "");
  add_fact(facts, "map", "{} x {} cells of {} m", m.map.width, m.map.height, m.map.resolution_m);
  if (results.relations && results.relations->compared > 0)
    facts.push_back({"relation error", tools::relations_text(*results.relations)});
  add_fact(facts, "particles", "{}, resampled {} times; {}", m.config.slam.particles, resampled(m.records),
           depletion_text(m));
  if (m.scan_odometry) facts.push_back({"odometry", odometry_text(*m.scan_odometry)});
  if (m.loops) facts.push_back({"loops", loops_text(*m.loops)});
  if (m.interrupted && m.config.slam.close_loops) facts.push_back({"loops", "left open by the interruption"});
  facts.push_back({"memory", memory_text(m)});
  add_fact(facts, "time", "{:.2f} s for {:.2f} s of log ({:.1f} times real time)", m.wall_s, m.log_s,
           m.real_time_factor());
  facts.push_back({"backend", m.backend});
  facts.push_back({"digest", m.digest});
  return facts;
}

std::vector<std::string> warning_lines(const SlamResults& results) {
  const Mapping& m = results.mapping;
  std::vector<std::string> lines;
  if (results.mapping.odometry_chosen) lines.push_back(kOdometryFromScans);
  if (m.scan_odometry && m.scan_odometry->new_maps > 0)
    lines.push_back(fmt::format("the odometry from the scans was lost {} times: the map may be torn there",
                                m.scan_odometry->new_maps));
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) lines.push_back(fmt::format("{} {}", count, what));
  };
  add(m.warnings.broken_lines, "broken lines were skipped");
  add(m.warnings.backward_stamps, "scans go back in time; the order of the file was kept");
  if (const std::string trouble = m.times.trouble(); !trouble.empty()) {
    lines.push_back(trouble);
  } else {
    add(m.times.repeated(), "scans have the time stamp of the one before");
  }
  if (m.times.gaps() > 0)
    lines.push_back(fmt::format("{} gaps of more than {} s between scans, the longest {:.1f} s",
                                m.times.gaps(), ScanTimes::kGap_s, m.times.longest_gap_s()));
  add(m.warnings.beam_count_changes, "scans have another number of beams than the one before");
  add(m.odometry_jumps, "jumps of the odometry");
  const std::vector<std::string> notes = open_notes(m.warnings.notes, m.config.lidars);
  lines.insert(lines.end(), notes.begin(), notes.end());
  lines.insert(lines.end(), m.warnings.messages.begin(), m.warnings.messages.end());
  return lines;
}

Json memory_json(const Mapping& m) {
  const SlamMemory& memory = m.memory;
  return {{"tile_bytes", memory.tile_bytes},
          {"most_tile_bytes", memory.most_tile_bytes},
          {"table_bytes", memory.table_bytes},
          {"sub_map_bytes", memory.sub_map_bytes},
          {"resident_bytes", json_of(m.resident_bytes)}};
}

Json truth_json(const std::optional<TrackErrors>& errors) {
  if (!errors) return nullptr;
  const bool known = errors->compared > 0;
  const auto value = [&](double v) { return json_if(known, v); };
  return {{"compared", errors->compared},
          {"without_truth", errors->without_truth},
          {"position_rmse_m", value(errors->position_rmse_m)},
          {"position_mae_m", value(errors->position_mae_m)},
          {"position_max_m", value(errors->position_max_m)},
          {"heading_rmse_rad", value(errors->heading_rmse_rad)},
          {"heading_max_rad", value(errors->heading_max_rad)}};
}

Json n_eff_json(const std::vector<SlamRecord>& records) {
  double least = records.front().n_eff, sum = 0.0;
  for (const SlamRecord& r : records) least = std::min(least, r.n_eff), sum += r.n_eff;
  return {{"least", least}, {"mean", sum / static_cast<double>(records.size())}};
}

/// One list per value, an entry per scan that was taken in.
Json scans_json(const Mapping& m) {
  Json stamp = Json::array(), n_eff = Json::array(), resampled = Json::array(), tiles = Json::array(),
       handed_over = Json::array(), step = Json::array();
  for (const SlamRecord& r : m.records) {
    stamp.push_back(r.stamp_s), n_eff.push_back(r.n_eff);
    resampled.push_back(r.resampled ? 1 : 0), tiles.push_back(r.tiles);
    handed_over.push_back(r.handed_over);
  }
  for (const double s : m.step_s) step.push_back(1e3 * s);
  return {{"stamp_s", stamp},           {"n_eff", n_eff}, {"resampled", resampled}, {"tiles", tiles},
          {"handed_over", handed_over}, {"step_ms", step}};
}

std::vector<double> stamps_of(const std::vector<SlamRecord>& records) {
  std::vector<double> stamps;
  for (const SlamRecord& r : records) stamps.push_back(r.stamp_s);
  return stamps;
}

Plot ancestors_plot(const Mapping& m) {
  Plot plot{"Ancestors of the last particles", "different poses", PlotScale::automatic};
  plot.series.push_back(
      {"", "c1", stamps_of(m.records), std::vector<double>(m.distinct.begin(), m.distinct.end())});
  plot.levels.push_back({"all particles", "c6", static_cast<double>(m.config.slam.particles)});
  return plot;
}

Plot memory_plot(const Mapping& m) {
  Plot plot{"Tiles of all maps", "MiB", PlotScale::from_zero};
  std::vector<double> tiles;
  for (const SlamRecord& r : m.records) tiles.push_back(static_cast<double>(r.tiles * sizeof(Tile)) / kMiB);
  plot.series.push_back({"", "c1", stamps_of(m.records), tiles});
  return plot;
}

std::vector<StepRecord> steps_of(const Mapping& m) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<StepRecord> steps;
  for (std::size_t k = 0; k < m.records.size(); ++k) {
    const SlamRecord& r = m.records[k];
    steps.push_back({r.stamp_s, r.n_eff, unknown, unknown, unknown, 1e3 * m.step_s[k], r.resampled});
  }
  return steps;
}

}  // namespace

void compare_with_truth(SlamResults& results, const Trajectory& truth) {
  const Trajectory& trajectory = results.mapping.trajectory;
  if (const std::optional<Pose> T_map_truth = best_alignment(trajectory, truth))
    results.truth = transformed(*T_map_truth, truth);
  results.errors = compare_tracks(trajectory, results.truth);
}

std::string metrics_json(const SlamResults& results) {
  const Mapping& m = results.mapping;
  Json json;
  json["parloc"] = PARLOC_VERSION;
  json["relations"] = tools::relations_json(results.relations);
  json["truth"] = truth_json(results.errors);
  json["odometry"] = odometry_json(results);
  json["loops"] = loops_json(m.loops);
  json["scans"] = m.scans;
  json["scans_taken_in"] = m.records.size();
  json["resumed_at"] = m.resumed_at;
  json["interrupted"] = m.interrupted;
  json["distance_m"] = length_m(m.trajectory);
  json["n_eff"] = n_eff_json(m.records);
  json["resampled"] = resampled(m.records);
  json["distinct_ancestors"] = m.distinct;  // by scan taken in
  json["ancestors_at_quarters"] = quarters(m.distinct);
  json["map"] = {{"width", m.map.width}, {"height", m.map.height}, {"resolution_m", m.map.resolution_m}};
  json["memory"] = memory_json(m);
  json["wall_s"] = m.wall_s;
  json["log_s"] = m.log_s;
  json["real_time_factor"] = m.real_time_factor();
  const TimeSummary step = summarise_times(m.step_s);
  json["step_ms_median"] = 1e3 * step.median_s;
  json["step_ms_p99"] = 1e3 * step.p99_s;
  json["step_ms_max"] = 1e3 * step.most_s;
  json["taken_in"] = scans_json(m);
  json["warnings"] = {{"broken_lines", m.warnings.broken_lines},
                      {"backward_stamps", m.warnings.backward_stamps},
                      {"repeated_stamps", m.times.repeated()},
                      {"stamps", text_or_null(m.times.trouble())},
                      {"gaps", m.times.gaps()},
                      {"beam_count_changes", m.warnings.beam_count_changes},
                      {"odometry_jumps", m.odometry_jumps},
                      {"notes", open_notes(m.warnings.notes, m.config.lidars)},
                      {"messages", m.warnings.messages}};
  json["backend"] = m.backend;
  json["seed"] = m.config.seed;
  json["digest"] = m.digest;
  json["log"] = results.log_path;
  json["command"] = results.command_line;
  json["config"] = tools::config_json(m.config);
  return file_text(json);
}

RunReport report_of(const SlamResults& results) {
  const Mapping& m = results.mapping;
  RunReport report;
  report.title = fmt::format("Map of {}", results.log_path);
  report.command_line = results.command_line;
  report.summary = main_facts(results);
  if (results.errors)
    report.summary.push_back({"truth", results.truth_path + ", turned and moved to where it fits best"});
  report.details = {tools::config_facts(m.config)};
  report.warnings = warning_lines(results);
  report.map = &m.map;
  report.estimate = m.trajectory;
  report.odometry = m.odometry;
  report.particles = static_cast<double>(m.config.slam.particles);
  report.steps = steps_of(m);
  report.plots = {ancestors_plot(m), memory_plot(m)};
  for (const Growth& g : m.growth) report.growth.push_back(moment_of(g));
  report.growth_note =
      "Distinct ancestors: how many different poses the particles of that moment have behind them at 0, 25, "
      "50 "
      "and 75 % of the scans taken in. Memory: the tiles of all maps together.";
  report.errors = results.errors;
  if (!results.truth.empty()) report.truth = results.truth;
  report.resample_below = m.config.slam.resample_threshold * report.particles;
  return report;
}

std::string summary_text(const SlamResults& results) {
  Facts facts = main_facts(results);
  if (results.errors && results.errors->compared > 0)
    add_fact(facts, "error", "{:.3f} m and {:.2f} degrees RMSE after alignment, from {} poses",
             results.errors->position_rmse_m, kDegPerRad * results.errors->heading_rmse_rad,
             results.errors->compared);
  for (const std::string& line : warning_lines(results)) facts.push_back({"warning", line});
  return aligned_text(facts, 16);
}

}  // namespace parloc::tools::slam
