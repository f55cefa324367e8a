#include "tools/run/run_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/io/log_notes.h"
#include "common/math/angle_units.h"
#include "tools/report/result_parts.h"
#include "tools/run/localize_log.h"

namespace parloc::tools {
namespace {

void add_track_errors(Json& json, const std::optional<TrackErrors>& errors) {
  const bool known = errors && errors->compared > 0;
  const auto add = [&](const char* key, double TrackErrors::*value) {
    json[key] = known ? Json((*errors).*value) : Json(nullptr);
  };
  add("position_rmse_m", &TrackErrors::position_rmse_m);
  add("position_mae_m", &TrackErrors::position_mae_m);
  add("position_max_m", &TrackErrors::position_max_m);
  add("position_p95_m", &TrackErrors::position_p95_m);
  add("heading_rmse_rad", &TrackErrors::heading_rmse_rad);
  add("heading_mae_rad", &TrackErrors::heading_mae_rad);
  add("heading_max_rad", &TrackErrors::heading_max_rad);
  json["compared_with_truth"] = errors ? Json(errors->compared) : Json(nullptr);
  json["without_truth"] = errors ? Json(errors->without_truth) : Json(nullptr);
}

/// NEES of x, y and heading: 3 is right, more is over-confident.
Json nees_json(const std::optional<Consistency>& c) {
  if (!c || c->compared == 0) return nullptr;
  return {{"mean", c->nees_mean},    {"median", c->nees_median}, {"within_95", c->within_95},
          {"x_mean", c->x_mean},     {"y_mean", c->y_mean},      {"heading_mean", c->heading_mean},
          {"compared", c->compared}, {"singular", c->singular}};
}

/// How far dead reckoning goes wrong: what the LiDAR is for.
Json odometry_json(const std::optional<TrackErrors>& errors) {
  if (!errors || errors->compared == 0) return nullptr;
  return {{"position_rmse_m", errors->position_rmse_m},
          {"position_max_m", errors->position_max_m},
          {"position_end_m", errors->position_error_m.back()},
          {"heading_end_rad", errors->heading_error_rad.back()}};
}

/// Counted troubles by name, for people and for JSON.
std::vector<std::pair<const char*, std::size_t>> counted(const Localization& run) {
  return {{"broken_lines", run.warnings.broken_lines},
          {"backward_stamps", run.warnings.backward_stamps},
          {"repeated_stamps", run.times.repeated()},
          {"beam_count_changes", run.warnings.beam_count_changes},
          {"unknown_messages", run.warnings.unknown_messages},
          {"odometry_jumps", run.odometry_jumps},
          {"lost_steps", run.lost_steps}};
}

Json rejected_json(const BeamCounts& beams) {
  Json json;
  for (const RejectReason& reason : kRejectReasons) json[reason.key] = beams.*reason.count;
  return json;
}

/// Null for a run that was not judged.
Json health_json(const std::optional<RunHealth>& h) {
  if (!h) return nullptr;
  const auto share = [&](std::size_t count) {
    return static_cast<double>(count) / static_cast<double>(h->scans);
  };
  Json modes = Json::array();
  for (const Mode& m : h->modes)
    modes.push_back(
        {{"x_m", m.pose.x_m}, {"y_m", m.pose.y_m}, {"theta_rad", m.pose.theta_rad}, {"weight", m.weight}});
  return {{"share_tracking", share(h->tracking)},
          {"share_ambiguous", share(h->ambiguous)},
          {"share_lost", share(h->lost)},
          {"searches", h->searches},
          {"turned_lost_s", h->lost_s},
          {"end_state", name_of(h->last.state)},
          {"end_probability", h->last.probability},
          {"end_evidence", h->last.evidence},
          {"end_modes", std::move(modes)}};
}

Json lidar_json(const LidarUse& lidar) {
  Json json{{"name", lidar.name},
            {"scans", lidar.scans},
            {"scans_with_too_few_beams", lidar.too_few},
            {"scans_deskewed", lidar.moving - lidar.unknown_motion},
            {"scans_of_unknown_motion", lidar.unknown_motion},
            {"max_beams", lidar.max_beams},
            {"beams_per_scan", {lidar.smallest, lidar.largest}},
            {"beams_total", lidar.beams.total},
            {"beams_considered", lidar.beams.considered},
            {"beams_used", lidar.beams.used},
            {"beams_without_return", lidar.beams.misses}};
  json["beams_rejected"] = rejected_json(lidar.beams);
  return json;
}

std::string position_text(const TrackErrors& e) {
  return fmt::format("mean {:.3f} m, RMSE {:.3f} m, 95 % {:.3f} m, maximum {:.3f} m", e.position_mae_m,
                     e.position_rmse_m, e.position_p95_m, e.position_max_m);
}
std::string heading_text(const TrackErrors& e) {
  return fmt::format("mean {:.2f}, RMSE {:.2f}, maximum {:.2f} degrees", e.heading_mae_rad * kDegPerRad,
                     e.heading_rmse_rad * kDegPerRad, e.heading_max_rad * kDegPerRad);
}
std::string consistency_text(const Consistency& c) {
  return fmt::format(
      "NEES {:.3g} in the mean, {:.3g} in the median (3 and 2.4 are right, more is over-confident)",
      c.nees_mean, c.nees_median);
}
std::string speed_text(const Localization& run) {
  const StepTimes times = step_times(run.steps);
  std::string text = fmt::format("{:.2f} s for {:.2f} s of log ({:.1f} times real time)", run.wall_s,
                                 run.log_s, run.real_time_factor());
  if (std::isfinite(times.median_ms)) {
    text += fmt::format(", a step {:.2f} ms (p99 {:.2f} ms)", times.median_ms, times.p99_ms);
  }
  return text;
}
std::string particles_text(const Localization& run) {
  const ParticleNumbers n = particle_numbers(run.steps);
  std::string text = fmt::format("{:.0f} in the mean, {} to {}", n.mean, n.min, n.max);
  if (n.injected_mean > 0.0) text += fmt::format("; {:.2g} % drawn from free space", 100.0 * n.injected_mean);
  return text;
}

/// "12 NaN, 3 zero"; empty without any.
std::string rejected_text(const BeamCounts& beams) {
  std::string text;
  for (const RejectReason& reason : kRejectReasons) {
    if (const std::size_t count = beams.*reason.count; count > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, reason.summary);
  }
  return text;
}

/// How many of how many beams were used of a LiDAR's scans, and why not the others.
std::string beams_text(const LidarUse& lidar, int min_beams) {
  const BeamCounts& beams = lidar.beams;
  const double scans = static_cast<double>(std::max<std::size_t>(lidar.scans, 1));
  const double total = static_cast<double>(beams.total) / scans;
  const double taken = static_cast<double>(beams.considered) / scans;
  std::string text = fmt::format("{:.4g} of ", taken);
  text += lidar.smallest == lidar.largest ? fmt::format("{} per scan", lidar.largest)
                                          : fmt::format("{} to {} per scan", lidar.smallest, lidar.largest);
  text += beams.considered == beams.total ? fmt::format(" (all; max_beams {})", lidar.max_beams)
                                          : fmt::format(" (evenly in angle, every {:.1f}th; max_beams {})",
                                                        total / taken, lidar.max_beams);
  if (beams.rejected() > 0) {
    const double percent =
        100.0 * static_cast<double>(beams.rejected()) / static_cast<double>(beams.considered);
    const int digits = percent < 10.0 ? 2 : 3;
    text += fmt::format("; {:.{}g} % dropped: {}", percent, digits, rejected_text(beams));
  }
  if (beams.masked > 0) text += fmt::format("; {} masked", beams.masked);
  if (beams.misses > 0) text += fmt::format("; {} saw nothing in range", beams.misses);
  if (lidar.too_few > 0) {
    text += fmt::format("; {} of {} scans not weighed: fewer than {} beams left (min_beams)", lidar.too_few,
                        lidar.scans, min_beams);
  }
  return text;
}

std::string deskewing_text(const LidarUse& lidar) {
  std::string text = fmt::format("{} of {} scans", lidar.moving - lidar.unknown_motion, lidar.scans);
  if (lidar.unknown_motion > 0)
    text += fmt::format("; for {} no odometry tells the motion", lidar.unknown_motion);
  return text;
}

void add_lidar_facts(Facts& facts, const Localization& run) {
  for (const LidarUse& lidar : run.lidars) {
    const std::string name = run.lidars.size() > 1 ? lidar.name + ": " : "";
    facts.push_back({"beams", name + beams_text(lidar, run.config.scan.min_beams)});
    if (lidar.moving > 0) facts.push_back({"deskewed", name + deskewing_text(lidar)});
  }
}

std::string last_error(const TrackErrors& e) {
  return fmt::format("{:.3f} m and {:.2f} degrees", e.position_error_m.back(),
                     std::abs(e.heading_error_rad.back()) * kDegPerRad);
}
std::string end_text(const TrackErrors& estimate, const std::optional<TrackErrors>& odometry) {
  std::string text = last_error(estimate) + " off";
  if (odometry && odometry->compared > 0 && std::isfinite(odometry->position_error_m.back())) {
    text += fmt::format("; odometry alone {}", last_error(*odometry));
  }
  return text;
}

/// How the particles spread, at the start and each third of the run: standard deviation in x and y together.
std::string spread_text(const Localization& run) {
  std::string text;
  for (std::size_t k = 0; k <= 3; ++k) {
    const StepRecord& step = run.steps[k * (run.steps.size() - 1) / 3];
    text += fmt::format("{}{:.2f} m after {:.1f} s", k == 0 ? "" : ", ",
                        std::hypot(step.sigma_x_m, step.sigma_y_m), step.stamp_s - run.steps.front().stamp_s);
  }
  return text;
}

/// What the report's first table and the summary on the terminal both say.
Facts main_facts(const RunResults& results) {
  const Localization& run = results.run;
  Facts facts;
  add_fact(facts, "scans", "{}{}{}", run.scans, run.odometry_only ? ", none used" : "",
           run.interrupted ? " (interrupted)" : "");
  if (results.errors && results.errors->compared > 0) {
    facts.push_back({"position error", position_text(*results.errors)});
    facts.push_back({"heading error", heading_text(*results.errors)});
    facts.push_back({"at the end", end_text(*results.errors, results.odometry_errors)});
  }
  if (results.consistency && results.consistency->compared > 0) {
    facts.push_back({"consistency", consistency_text(*results.consistency)});
  }
  if (run.odometry_only) facts.push_back({"spread", spread_text(run)});
  if (results.errors && results.errors->without_truth > 0) {
    add_fact(facts, "no truth for", "{} scans", results.errors->without_truth);
  }
  if (const std::optional<RunHealth> health = run_health(run))
    facts.push_back({"health", health_text(*health)});
  if (results.relations && results.relations->compared > 0) {
    facts.push_back({"relation error", relations_text(*results.relations)});
  }
  if (run.config.adapts_particles()) facts.push_back({"particles", particles_text(run)});
  facts.push_back({"time", speed_text(run)});
  if (!run.odometry_only) add_lidar_facts(facts, run);
  facts.push_back({"backend", run.backend});
  facts.push_back({"digest", run.digest});
  if (!results.mcap_path.empty())
    add_fact(facts, "recorded", "{}: {} messages, {:.1f} MB", results.mcap_path, results.mcap_messages,
             static_cast<double>(results.mcap_bytes) / 1e6);
  return facts;
}

/// One line per kind of trouble, then the reader's own words on the first few.
std::vector<std::string> warning_lines(const Localization& run) {
  std::vector<std::string> lines;
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) lines.push_back(fmt::format("{} {}", count, what));
  };
  add(run.warnings.broken_lines, "broken lines were skipped");
  add(run.warnings.backward_stamps, "scans go back in time; the order of the file was kept");
  if (const std::string trouble = run.times.trouble(); !trouble.empty()) lines.push_back(trouble);
  add(run.warnings.beam_count_changes, "scans have another number of beams than the one before");
  add(run.odometry_jumps, "jumps of the odometry");
  add(run.lost_steps, "steps in which no particle fitted the scan");
  if (const std::string unused = unused_lidars(run.config, run.lidars); !unused.empty())
    lines.push_back(unused);
  const std::vector<std::string> notes = open_notes(run.warnings.notes, run.config.lidars);
  lines.insert(lines.end(), notes.begin(), notes.end());
  lines.insert(lines.end(), run.warnings.messages.begin(), run.warnings.messages.end());
  return lines;
}

FactTable map_facts(const RunResults& results, const GridMap& map) {
  return {"Input",
          {{"map", fmt::format("{}: {} x {} cells of {} m", results.map_path, map.width, map.height,
                               map.resolution_m)},
           {"log", results.log_path},
           {"truth", results.truth_path.empty() ? "none" : results.truth_path},
           {"start", results.init}}};
}

}  // namespace

std::string metrics_json(const RunResults& results) {
  const Localization& run = results.run;
  Json json;
  json["parloc"] = PARLOC_VERSION;
  add_track_errors(json, results.errors);
  json["nees"] = nees_json(results.consistency);
  json["odometry_only"] = run.odometry_only;
  json["odometry"] = odometry_json(results.odometry_errors);
  json["health"] = health_json(run_health(run));
  json["relations"] = relations_json(results.relations);
  json["steps"] = run.filter_steps;
  json["scans"] = run.scans;
  json["interrupted"] = run.interrupted;
  json["wall_s"] = run.wall_s;
  json["log_s"] = run.log_s;
  const StepTimes times = step_times(run.steps);
  json["step_ms_median"] = times.median_ms;  // NaN is written as null
  json["step_ms_p99"] = times.p99_ms;
  json["real_time_factor"] = run.real_time_factor();
  const ParticleNumbers numbers = particle_numbers(run.steps);
  json["particles"] = {{"mean", numbers.mean}, {"min", numbers.min}, {"max", numbers.max}};
  json["injected_mean"] = numbers.injected_mean;
  json["beams_total"] = run.beams.total;
  json["beams_considered"] = run.beams.considered;
  json["beams_used"] = run.beams.used;
  json["beams_without_return"] = run.beams.misses;
  json["beams_rejected"] = rejected_json(run.beams);
  for (const LidarUse& lidar : run.lidars) json["lidars"].push_back(lidar_json(lidar));
  for (const auto& [what, count] : counted(run)) json["warnings"][what] = count;
  json["warnings"]["stamps"] = text_or_null(run.times.trouble());
  json["warnings"]["notes"] = open_notes(run.warnings.notes, run.config.lidars);
  json["warnings"]["messages"] = run.warnings.messages;
  json["backend"] = run.backend;
  json["seed"] = run.config.seed;
  json["digest"] = run.digest;
  json["map"] = results.map_path;
  json["log"] = results.log_path;
  json["truth"] = text_or_null(results.truth_path);
  json["init"] = results.init;
  json["mcap"] = text_or_null(results.mcap_path);
  json["command"] = results.command_line;
  json["config"] = config_json(run.config);
  return file_text(json);
}

RunReport run_report(const RunResults& results, const GridMap& map) {
  const Localization& run = results.run;
  RunReport report;
  report.title = fmt::format("{} on {}", results.log_path, results.map_path);
  report.command_line = results.command_line;
  report.summary = main_facts(results);
  report.details = {map_facts(results, map), config_facts(run.config)};
  report.warnings = warning_lines(run);
  if (const std::string doubt = doubt_at_end(run); !doubt.empty()) report.summary.push_back({"end", doubt});
  report.map = &map;
  report.estimate = run.trajectory;
  if (!results.truth.empty()) report.truth = results.truth;
  report.odometry = run.odometry;
  report.errors = results.errors;
  report.steps = run.steps;
  report.adaptive = run.config.adapts_particles();
  if (!report.adaptive) {
    report.particles = static_cast<double>(run.config.most_particles());
    report.resample_below = run.config.resample.threshold * report.particles;
  }
  report.snapshots = run.snapshots;
  report.every_cloud = run.odometry_only;
  return report;
}

std::string run_summary(const RunResults& results) {
  Facts facts = main_facts(results);
  const std::vector<std::string> warnings = warning_lines(results.run);
  constexpr std::size_t most = 8;
  for (std::size_t i = 0; i < warnings.size() && i < most; ++i) facts.push_back({"warning", warnings[i]});
  if (warnings.size() > most) add_fact(facts, "warning", "{} more in metrics.json", warnings.size() - most);
  return aligned_text(facts, 16);
}

}  // namespace parloc::tools
