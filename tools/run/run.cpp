// parloc run: localizes a log on a map.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/file/output_file.h"
#include "common/filter/filter_settings.h"
#include "common/io/open_log.h"
#include "common/io/open_map.h"
#include "common/io/open_truth.h"
#include "common/io/trajectory.h"
#include "tools/program/commands.h"
#include "tools/program/note_teller.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"
#include "tools/report/report.h"
#include "tools/run/localize_log.h"
#include "tools/run/mcap_record.h"
#include "tools/run/pose_file.h"
#include "tools/run/run_results.h"

namespace parloc::tools {
namespace {

/// The command line; what was not given is empty.
struct RunOptions : ConfigOptions {
  std::vector<std::string> init;
  std::string map, log, truth, relations, near, heading, particles, mcap;
  std::string out = "parloc_out";
  std::optional<PoseFormat> poses;
  bool odometry_only = false, strict = false, json = false, quiet = false;
};

void declare(CLI::App& app, RunOptions& o) {
  add_text_option(app, "--map", o.map, "M.yaml", "ROS map_server YAML, or a bag (the log, if a bag)");
  add_log_options(app, o, o.log)->required();
  add_text_option(app, "--truth", o.truth, "T.tum",
                  "True poses: TUM, CARMEN, bag (--relations R.txt: relations)");
  add_text_option(app, "--relations", o.relations, "R.txt", "True relations between scans")->group("");
  add_text_option(app, "--config", o.config, "C.yaml", "Settings over the defaults");
  add_text_option(app, "--init", o.init, "START", "x,y,theta[,sx,sy,st] (again: or there), or global")
      ->allow_extra_args(false);
  add_text_option(app, "--near", o.near, "X,Y,R", "global within R of (X, Y) [m]; --heading A,T: A +- T");
  add_text_option(app, "--heading", o.heading, "A,T", "Headings from A - T to A + T only [rad]")->group("");
  add_text_option(app, "--out", o.out, "DIR", "Folder for the results (parloc_out)");
  add_choice_option(app, "--poses", o.poses, kPoseFormats, "FORMAT",
                    "Poses with all that is said of them: csv, jsonl, none");
  add_text_option(app, "--mcap", o.mcap, "F.mcap", "For Foxglove and RViz, as it runs (docs/mcap.md)");
  add_choice_option(app, "--backend", o.backend, kBackends, "WHICH",
                    "auto, cpu or cuda; --device D is one of several GPUs");
  add_text_option(app, "--device", o.device, "D", "CUDA device, as parloc devices lists them")->group("");
  add_text_option(app, "--particles", o.particles, "N", "A fixed number, 1 to 16777216");
  add_text_option(app, "--beams", o.beams, "B", "Beams used of a scan, 1 to 4096");
  add_text_option(app, "--seed", o.seed, "S", "Same seed, same answer");
  add_text_option(app, "--threads", o.threads, "K", "CPU threads; 0: all cores");
  app.add_flag("--odometry-only", o.odometry_only, "Move the particles, use no scan");
  app.add_flag("--strict", o.strict, "Broken data end the run; a doubt at its end is code 7");
  app.add_flag("--json", o.json, "Print the metrics alone, as JSON");
  app.add_flag("--quiet", o.quiet, "No progress and no summary");
  app.get_help_ptr()->group("");  // whoever reads the list knows it
}

/// Where it starts, as far as the command line says so.
std::optional<StartPose> start_of(const RunOptions& o, const Config& config) {
  if (o.init.empty() && o.truth.empty()) {
    throw Error(ErrorKind::usage, "no start pose: give --init x,y,theta, --init global, or --truth");
  }
  std::optional<StartPose> start;
  if (!o.init.empty()) start = parse_start_poses(o.init, config);
  if (o.near.empty() && o.heading.empty()) return start;
  if (!start || !start->anywhere || !config.localize.health || o.odometry_only) {
    throw Error(ErrorKind::usage,
                "--near and --heading restrict a search: expected --init global, with localize.health and "
                "without --odometry-only");
  }
  start->prior = parse_search_prior(o.near, o.heading);
  return start;
}

std::string start_text(const RunOptions& o) {
  if (o.init.empty()) return "truth";
  std::string text = fmt::format("{}", fmt::join(o.init, "; "));
  if (!o.near.empty()) text += " near " + o.near;
  if (!o.heading.empty()) text += " heading " + o.heading;
  return text;
}

constexpr const char* kTrajectory = "trajectory.tum";
constexpr const char* kMetrics = "metrics.json";
constexpr const char* kReport = "report.html";
constexpr const char* kPicture = "picture.png";
constexpr const char* kErrors = "errors.png";  // with a truth

bool has_errors(const RunResults& results) {
  return results.errors && results.errors->compared > 0;
}

/// The file's name; empty for none.
std::string poses_name(PoseFormat format) {
  return format == PoseFormat::csv ? kPosesCsv : format == PoseFormat::jsonl ? kPosesJsonl : "";
}

/// What stands beside the report.
std::string others_text(const RunResults& results, PoseFormat format) {
  std::vector<std::string> names{kPicture};
  if (has_errors(results)) names.push_back(kErrors);
  names.push_back(kTrajectory);
  if (format != PoseFormat::none) names.push_back(poses_name(format));
  names.push_back(kMetrics);
  return fmt::format("{}", fmt::join(names, ", "));
}

void write_results(OutputFolder& out, const RunResults& results, const GridMap& map) {
  const RunReport report = run_report(results, map);
  write_tum(out.staged(kTrajectory), results.run.trajectory);
  replace_file(out.staged(kMetrics), metrics_json(results));
  write_report(out.staged(kReport), report);
  write_picture(out.staged(kPicture), report);
  if (has_errors(results)) write_error_picture(out.staged(kErrors), report);
  out.publish();
}

/// Nothing without --mcap.
std::unique_ptr<McapRecord> record_for(const RunOptions& o, const GridMap& map, const LocalizeRequest& r) {
  if (o.mcap.empty()) return nullptr;
  for (const std::string& input : {o.log, o.map, o.truth, o.relations, o.config}) {
    std::error_code error;
    if (!input.empty() && std::filesystem::equivalent(input, o.mcap, error) && !error)
      throw Error(ErrorKind::usage, fmt::format("--mcap: {} is read in this run", input));
  }
  return std::make_unique<McapRecord>(o.mcap, map, r.truth, r.config);
}

int run(const RunOptions& given, const std::string& typed) {
  // Everything that can be wrong is looked at before the long work.
  RunOptions o = given;
  std::optional<Pose> nav2_start;
  LocalizeRequest request;
  request.config = effective_config(
      o,
      [&](Config& config) {
        if (set_whole_number(config, "particles", "--particles", o.particles))
          config.min_particles = config.max_particles = 0;  // a fixed number, whatever the file says
      },
      {}, &nav2_start);
  if (o.init.empty() && nav2_start)
    o.init = {fmt::format("{},{},{}", nav2_start->x_m, nav2_start->y_m, nav2_start->theta_rad)};
  o.map = map_or_log(o.map, o.log);
  o.truth = truth_or_log(o.truth, o.log, request.config);
  request.log_name = o.log;
  request.strict = o.strict;
  request.odometry_only = o.odometry_only;
  request.start = start_of(o, request.config);
  const GridMap map = open_map(o.map, log_choice(request.config));
  print_notes(map.notes);
  const std::unique_ptr<LogReader> log = open_log(o.log, log_choice(request.config));
  if (!o.truth.empty()) request.truth = open_truth(o.truth, log_choice(request.config));
  const std::vector<Relation> relations =
      o.relations.empty() ? std::vector<Relation>{} : read_relations(o.relations);
  OutputFolder out(o.out, {kTrajectory, kPosesCsv, kPosesJsonl, kMetrics, kReport, kPicture, kErrors});
  const PoseFormat format = o.poses.value_or(PoseFormat::csv);
  PoseFile poses(format, out.staged(poses_name(format)));
  const std::unique_ptr<McapRecord> record = record_for(o, map, request);

  RunResults results{o.map, o.log, o.truth, o.relations, typed, start_text(o), {}, {}, {}, {}, {}, {}};
  catch_interrupts();
  {
    Progress progress(o.quiet);
    request.progress = [&](double fraction, std::size_t scans) {
      progress.update(fraction, fmt::format("{} scans", scans));
    };
    request.answered = [&](const ScanAnswer& answer) { poses.write(answer); };
    if (record) request.stepped = [&](const StepView& step) { record->add(step); };
    NoteTeller notes(o.log, request.config.lidars, o.quiet);
    request.read = [&](const LogWarnings& warnings) { notes.tell(warnings); };
    request.stop = interrupted;
    results.run = localize_log(map, *log, request);
  }
  if (results.run.scans == 0) {
    fmt::print(stderr, "parloc: interrupted before the first scan, nothing is written\n");
    return kExitInterrupted;
  }
  results.truth = std::move(request.truth);
  if (!o.truth.empty()) {
    results.errors = compare_tracks(results.run.trajectory, results.truth);
    results.consistency = check_consistency(*results.errors, results.run.covariances);
    results.odometry_errors = compare_tracks(results.run.odometry, results.truth);
  }
  if (!o.relations.empty()) results.relations = compare_relations(results.run.trajectory, relations);
  poses.commit();
  if (record) {
    record->finish();
    results.mcap_path = o.mcap;
    results.mcap_messages = record->messages();
    results.mcap_bytes = record->bytes();
  }
  write_results(out, results, map);

  if (o.json) {
    std::fputs(metrics_json(results).c_str(), stdout);
  } else if (!o.quiet) {
    fmt::print("{}{:<16}{} (beside it: {})\n", run_summary(results), "report", out.final_path(kReport),
               others_text(results, format));
  }
  const std::string doubt = doubt_at_end(results.run);
  if (!doubt.empty()) fmt::print(stderr, "parloc: {}\n", doubt);
  if (results.run.interrupted) return kExitInterrupted;
  return o.strict && !doubt.empty() ? kExitNotFound : 0;
}

}  // namespace

Command add_run_command(CLI::App& program) {
  return add_command<RunOptions>(program, "run", "Localize a log on a map", declare, run);
}

}  // namespace parloc::tools
