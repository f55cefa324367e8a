// parloc learn: the numbers of the beam mixture, from a log with known poses; or where LiDARs sit and how the
// odometry errs, from a log alone.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/error.h"
#include "common/file/output_file.h"
#include "common/inputs/open_log.h"
#include "common/inputs/open_map.h"
#include "common/inputs/open_truth.h"
#include "common/model/model_settings.h"
#include "tools/learn/calibrate.h"
#include "tools/learn/learn.h"
#include "tools/learn/odometry_delay.h"
#include "tools/program/commands.h"
#include "tools/program/note_teller.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"

namespace parloc::tools {
namespace {

struct LearnOptions : ConfigOptions {
  std::string map, log, truth;
  std::string out = "parloc_learned", what = "sensor";
  bool quiet = false, json = false;
};

constexpr const char* kConfig = "sensor.yaml";
constexpr const char* kMixturePicture = "mixture.png";

void declare(CLI::App& app, LearnOptions& o) {
  add_text_option(app, "--map", o.map, "M.yaml", "ROS map_server YAML");
  add_log_options(app, o, o.log)->required();
  add_text_option(app, "--truth", o.truth, "T.tum", "True poses, or the trajectory.tum of a run");
  add_text_option(app, "--what", o.what, "W", "sensor (default), or some of mount,odometry,delay");
  add_text_option(app, "--config", o.config, "C.yaml", "Where the search starts, and which beams are used");
  add_text_option(app, "--beams", o.beams, "B", "Beams used of a scan, 1 to 4096");
  add_text_option(app, "--out", o.out, "DIR", "Folder for the results (parloc_learned)");
  app.add_flag("--quiet", o.quiet, "No progress; print the settings alone");
  app.add_flag("--json", o.json, "mount, odometry, delay: print JSON instead");
  app.footer(
      "sensor: learns z_hit, z_short, z_max, z_rand, sigma_hit and lambda_short of beam and\n"
      "class_conditional from measured and expected ranges (EM), with --map and --truth.\n"
      "mount,odometry,delay: where LiDARs sit, scales and delay of the odometry, from the\n"
      "log alone, with standard deviations (docs/calibration.md).");
}

Config learn_config(const LearnOptions& o) {
  return effective_config(o, [&](Config& config) {
    const SensorModel model = config.sensor.model;
    if (model != SensorModel::beam && model != SensorModel::class_conditional)
      config.sensor = default_sensor(SensorModel::beam);
    if (!o.beams.empty()) config.scan.min_beams = 1;
  });
}

/// A start from which every cause can grow.
Mixture start_of(const SensorConfig& c) {
  const auto share = [](double z) { return std::max(z, 0.01); };
  const double sum = share(c.z_hit) + share(c.z_short) + share(c.z_max) + share(c.z_rand);
  return {share(c.z_hit) / sum, share(c.z_short) / sum, share(c.z_max) / sum, share(c.z_rand) / sum,
          c.sigma_hit,          c.lambda_short};
}

std::string sensor_block(const SensorConfig& s, const std::string& typed) {
  return fmt::format(
      "# learned by: {}\n"
      "sensor:\n"
      "  model: {}\n"
      "  z_hit: {:g}\n"
      "  z_short: {:g}\n"
      "  z_max: {:g}\n"
      "  z_rand: {:g}\n"
      "  sigma_hit: {:g}        # [m]\n"
      "  lambda_short: {:g}     # [1/m]\n",
      typed, name_of(s.model, kSensorModels), s.z_hit, s.z_short, s.z_max, s.z_rand, s.sigma_hit,
      s.lambda_short);
}

/// A remark, to be tried: on logs with irregular stamps it was off by half (docs/how_it_works.md).
std::string motion_block(const OdometryDelay& delay) {
  return fmt::format("# motion: {{odometry_delay_s: {:.3f}}}   # [s], standard error {:.3f}: try it\n",
                     delay.delay_s, delay.sigma_s);
}

std::string delay_text(const std::optional<OdometryDelay>& delay) {
  if (!delay) return "not known: too few turns, or too far apart";
  return fmt::format("{:.3f} s, standard error {:.3f} s, from {} turns{}", delay->delay_s, delay->sigma_s,
                     delay->turns, delay->significant() ? "" : ": not sure to be another than 0");
}

RangePairsOfLog collect(const LearnOptions& o, const Config& config) {
  const GridMap map = open_map(o.map, log_choice(config));
  const std::unique_ptr<LogReader> log = open_log(o.log, log_choice(config));
  const Trajectory truth = open_truth(o.truth, log_choice(config));
  Progress progress(o.quiet);
  const RangePairsOfLog found = collect_range_pairs(map, *log, truth, config, [&](double fraction) {
    progress.update(fraction);
    return !interrupted();
  });
  NoteTeller(o.log, config.lidars, o.quiet).tell(log->warnings());
  return found;
}

[[noreturn]] void refuse(const LearnOptions& o, const RangePairsOfLog& found) {
  throw input_error(
      o.log, 0,
      fmt::format("expected at least {} beams with a true pose, found {} in {} scans, {} of them "
                  "without a pose in {}",
                  kFewestPairs, found.ranges.pairs.size(), found.scans, found.without_pose, o.truth));
}

int run(const LearnOptions& o, const std::string& typed) {
  if (o.what != "sensor") {
    if (!o.map.empty() || !o.truth.empty())
      throw Error(ErrorKind::usage, "--map and --truth are for --what sensor");
    return calibrate_log({o.log, o.what, o.out, o.quiet, o.json}, effective_config(o), typed);
  }
  if (o.map.empty()) throw Error(ErrorKind::usage, "--map is required");
  if (o.truth.empty()) throw Error(ErrorKind::usage, "--truth is required");
  const Config config = learn_config(o);
  OutputFolder out(o.out, {kConfig, kMixturePicture});
  catch_interrupts();
  const RangePairsOfLog found = collect(o, config);
  if (found.ranges.pairs.size() < kFewestPairs) {
    if (interrupted()) return kExitInterrupted;
    refuse(o, found);
  }
  const MixtureFit fit =
      fit_mixture(found.ranges, start_of(config.sensor), 500, 1e-7, [](int) { return !interrupted(); });
  Config learned = config;
  learned.sensor = with_mixture(config.sensor, fit.mixture);
  validate(learned);
  const std::optional<OdometryDelay> delay =
      estimate_odometry_delay(found.odometry, open_truth(o.truth, log_choice(config)));
  std::string block = sensor_block(learned.sensor, typed);
  if (delay && delay->significant()) block += motion_block(*delay);
  replace_file(out.staged(kConfig), block);
  write_mixture_picture(out.staged(kMixturePicture), found.ranges, fit.mixture);
  out.publish();
  std::fputs(block.c_str(), stdout);
  if (!o.quiet) {
    fmt::print(stderr, "{:<16}{} of {} scans, those without a pose: {}\n", "beams", found.ranges.pairs.size(),
               found.scans, found.without_pose);
    fmt::print(stderr, "{:<16}{:.4f} per beam after {} rounds, from {:.4f}{}\n", "log-likelihood",
               fit.log_likelihood.back(), fit.log_likelihood.size(), fit.log_likelihood.front(),
               fit.converged ? "" : " (not at its end yet)");
    fmt::print(stderr, "{:<16}{}\n", "odometry delay", delay_text(delay));
    fmt::print(stderr, "{:<16}{} (beside it: {})\n", "picture", out.final_path(kMixturePicture), kConfig);
  }
  return interrupted() ? kExitInterrupted : 0;
}

}  // namespace

Command add_learn_command(CLI::App& program) {
  return add_command<LearnOptions>(program, "learn", "Learn a sensor model, or where LiDARs sit, from a log",
                                   declare, run);
}

}  // namespace parloc::tools
