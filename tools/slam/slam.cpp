// parloc slam: makes a map from a log.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "common/file/output_file.h"
#include "common/filter/filter_settings.h"
#include "common/inputs/open_log.h"
#include "common/inputs/open_truth.h"
#include "common/map/map_reader.h"
#include "common/slam/slam_settings.h"
#include "tools/program/commands.h"
#include "tools/program/note_teller.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"
#include "tools/report/live_picture.h"
#include "tools/report/report.h"
#include "tools/slam/log_oddities.h"
#include "tools/slam/results.h"

namespace parloc::tools {
namespace {

/// The command line; what was not given is empty.
struct SlamOptions : ConfigOptions {
  std::string log, truth, relations, particles, out, resume, every;
  std::optional<SlamProposal> proposal;
  bool live = false, json = false, quiet = false;
};

void declare(CLI::App& app, SlamOptions& o) {
  add_log_options(app, o, o.log)->required();
  add_text_option(app, "--config", o.config, "C.yaml", "Settings over the defaults");
  add_text_option(app, "--truth", o.truth, "T.tum", "True trajectory (TUM, CARMEN, bag), any frame");
  add_text_option(app, "--relations", o.relations, "R.txt", "True relations between scans");
  add_text_option(app, "--out", o.out, "DIR", "Folder for the results (parloc_map)");
  add_text_option(app, "--particles", o.particles, "N", "Each with a map of its own, 1 to 65535");
  add_choice_option(app, "--proposal", o.proposal, kSlamProposals, "WHICH", "motion, scan_match or gaussian");
  add_choice_option(app, "--backend", o.backend, kBackends, "WHICH", "auto, cpu or cuda");
  add_text_option(app, "--seed", o.seed, "S", "Same seed, same map");
  add_text_option(app, "--threads", o.threads, "K", "CPU threads; 0: all cores");
  add_text_option(app, "--resume", o.resume, "DIR", "Go on from the checkpoint of an interrupted run");
  add_text_option(app, "--checkpoint-every", o.every, "S",
                  "Seconds between checkpoints (60); 0: if interrupted");
  app.add_flag("--live", o.live, "While it works: the map so far in DIR/live.html");
  app.add_flag("--json", o.json, "Print the metrics alone, as JSON");
  app.add_flag("--quiet", o.quiet, "No progress and no summary");
  app.get_help_ptr()->group("");  // whoever reads the list knows it
}

/// The configuration file over `base`, with the command line on top.
Config slam_config(const SlamOptions& o, const Config& base) {
  const auto change = [&](Config& config) {
    set_whole_number(config, "slam.particles", "--particles", o.particles);
    if (o.proposal) config.slam.proposal = *o.proposal;
  };
  return effective_config(o, change, base);
}

constexpr const char* kMap = "map.yaml";
constexpr const char* kImage = "map.pgm";
constexpr const char* kSlamTrajectory = "trajectory.tum";
constexpr const char* kSlamMetrics = "metrics.json";
constexpr const char* kSlamReport = "report.html";
constexpr const char* kMapPicture = "picture.png";
constexpr const char* kLivePicture = "live.png";  // while it works
constexpr const char* kLivePage = "live.html";

constexpr const char* kCheckpoint = "checkpoint";

/// --resume takes the folder as well as the file.
std::string checkpoint_path(const SlamOptions& o) {
  const bool folder = std::filesystem::is_directory(o.resume);
  return folder ? (std::filesystem::path(o.resume) / kCheckpoint).string() : o.resume;
}

/// The checkpoint's settings hold; what is given besides must not contradict them, but for where the work is
/// done.
Config resumed_config(const SlamOptions& o, SlamCheckpoint& checkpoint) {
  const Config config = slam_config(o, config_of(checkpoint.config));
  const std::string change = config_difference(checkpoint.config, grid_slam_config(config));
  if (!change.empty())
    throw Error(ErrorKind::usage, fmt::format("--resume: {}: {}", checkpoint.name(), change));
  checkpoint.config = grid_slam_config(config);
  return config;
}

std::string output_folder(const SlamOptions& o) {
  if (!o.out.empty()) return o.out;
  if (o.resume.empty()) return "parloc_map";
  const std::string folder = std::filesystem::path(checkpoint_path(o)).parent_path().string();
  return folder.empty() ? "." : folder;
}

void write_results(OutputFolder& out, const slam::SlamResults& results) {
  const RunReport report = slam::report_of(results);
  write_map(out.staged(kMap), results.mapping.map);
  write_tum(out.staged(kSlamTrajectory), results.mapping.trajectory);
  replace_file(out.staged(kSlamMetrics), slam::metrics_json(results));
  write_report(out.staged(kSlamReport), report);
  write_picture(out.staged(kMapPicture), report);
  const bool interrupted = results.mapping.interrupted;
  out.publish(interrupted ? std::vector<std::string>{kCheckpoint} : std::vector<std::string>{});
}

void watch(slam::MapRequest& request, std::optional<LivePicture>& live, const OutputFolder& out) {
  live.emplace(out.final_path(kLivePicture), out.final_path(kLivePage), "Map of " + request.log_name,
               kSlamReport);
  request.watch = [&live](const GridSlam& slam, std::size_t scans) {
    live->offer([&](const std::string& path) { slam::write_live(path, slam::growth_of(slam, scans)); });
  };
}

int run(const SlamOptions& given, const std::string& typed) {
  SlamOptions o = given;
  // Everything that can be wrong is looked at before the long work.
  slam::MapRequest request;
  std::optional<SlamCheckpoint> checkpoint;
  if (!o.resume.empty()) checkpoint.emplace(checkpoint_path(o));
  request.config = checkpoint ? resumed_config(o, *checkpoint) : slam_config(o, Config{});
  o.truth = truth_or_log(o.truth, o.log, request.config);
  request.resume = checkpoint ? &*checkpoint : nullptr;
  request.checkpoint_every_s = o.every.empty() ? 60.0 : parse_number("--checkpoint-every", o.every, 0.0, 1e6);
  request.log_name = o.log;
  request.odometry_chosen = !checkpoint && slam::choose_odometry(o.log, request.config);
  if (request.odometry_chosen) fmt::print(stderr, "parloc: {}: {}\n", o.log, slam::kOdometryFromScans);
  const std::unique_ptr<LogReader> log = open_log(o.log, log_choice(request.config));
  const std::vector<Relation> relations =
      o.relations.empty() ? std::vector<Relation>{} : read_relations(o.relations);
  const Trajectory truth = o.truth.empty() ? Trajectory{} : open_truth(o.truth, log_choice(request.config));
  OutputFolder out(output_folder(o), {kMap, kImage, kSlamTrajectory, kSlamMetrics, kSlamReport, kMapPicture,
                                      kLivePicture, kLivePage, kCheckpoint});
  request.checkpoint = out.final_path(kCheckpoint);
  std::optional<LivePicture> live;  // to the end of the writing: its page then leads to the report
  if (o.live) watch(request, live, out);

  slam::SlamResults results{o.log, o.relations, o.truth, typed, {}, {}, {}, {}};
  catch_interrupts();
  {
    Progress progress(o.quiet);
    std::optional<Progress> closing;
    request.closing = [&](double fraction) {
      if (!closing) closing.emplace(o.quiet);
      closing->update(fraction, "closing loops");
    };
    request.progress = [&](double fraction, std::size_t scans) {
      progress.update(fraction,
                      fmt::format("{} scans{}", scans, o.live ? ", see " + out.final_path(kLivePage) : ""));
    };
    NoteTeller notes(o.log, request.config.lidars, o.quiet);
    request.read = [&](const LogWarnings& warnings) { notes.tell(warnings); };
    request.stop = interrupted;
    results.mapping = slam::map_log(*log, request);
  }
  if (results.mapping.scans == 0) {
    fmt::print(stderr, "parloc: interrupted before the first scan, nothing is written\n");
    return kExitInterrupted;
  }
  if (results.mapping.records.empty()) {
    fmt::print(stderr, "parloc: interrupted before a scan was taken in, there is only {}\n",
               request.checkpoint);
    return kExitInterrupted;
  }
  if (!o.truth.empty()) slam::compare_with_truth(results, truth);
  if (!o.relations.empty()) results.relations = compare_relations(results.mapping.trajectory, relations);
  write_results(out, results);
  if (o.json) {
    std::fputs(slam::metrics_json(results).c_str(), stdout);
  } else if (!o.quiet) {
    fmt::print("{}{:<16}{} (beside it: {}, {}, {}, {})\n", slam::summary_text(results), "map",
               out.final_path(kMap), kSlamReport, kMapPicture, kSlamTrajectory, kSlamMetrics);
    if (results.mapping.interrupted)
      fmt::print("{:<16}parloc slam --resume {} --log {}\n", "to go on", request.checkpoint, o.log);
  }
  return results.mapping.interrupted ? kExitInterrupted : 0;
}

}  // namespace

Command add_slam_command(CLI::App& program) {
  return add_command<SlamOptions>(program, "slam", "Make a map from a log", declare, run);
}

}  // namespace parloc::tools
