// parloc evaluate: many trials of the localizer, simulated or from a log, and what they say together; or the
// relation error of a trajectory.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "common/file/output_file.h"
#include "common/inputs/open_map.h"
#include "common/map/map_reader.h"
#include "common/simulator/scenario.h"
#include "tools/evaluate/decided_trials.h"
#include "tools/evaluate/evaluate_relations.h"
#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/families/evaluate_families.h"
#include "tools/evaluate/trials.h"
#include "tools/program/commands.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"
#include "tools/program/typed_command.h"
#include "tools/report/machine/statistics.h"
#include "tools/shards/sharding.h"
#include "tools/shards/trial_bytes.h"

namespace parloc::tools {
namespace {

using evaluate::Evaluation;

/// The command line; what was not given is empty.
struct EvaluateOptions {
  ConfigOptions filter;
  shards::ShardOptions part;
  std::string scenario, log, map, truth, task, trials, starts, seed, bar, against, error, duration, limit,
      particles, range, fov, jobs, samples, trajectory, relations, dataset, out, maps, corrupt;
  std::vector<std::string> family;
  bool families = false, json = false, quiet = false;
};

void declare(CLI::App& app, EvaluateOptions& o) {
  add_text_option(app, "--scenario", o.scenario, "S.yaml", "Simulate its LiDAR, odometry and clutter");
  add_log_options(app, o.filter, o.log, "Or take a recorded log, ...");
  add_text_option(app, "--truth", o.truth, "T.tum", "... with its true path, from --starts K times (20)");
  add_text_option(app, "--starts", o.starts, "K", "Spread over the log")->group("");
  add_text_option(app, "--map", o.map, "M.yaml", "Map to localize on (the scenario's)");
  add_text_option(app, "--task", o.task, "WHAT", "global, kidnap or track (global)")
      ->check(one_of({"global", "kidnap", "track"}));
  add_text_option(app, "--trials", o.trials, "N", "How many, from --seed K on (100; of a log, all starts)");
  add_text_option(app, "--seed", o.seed, "FIRST", "First seed; of a log, first start (1)")->group("");
  add_text_option(app, "--bar", o.bar, "SHARE", "Only until known if success is so much (--error 0.05)");
  add_text_option(app, "--against", o.against, "C.yaml", "Only until known which of both is better");
  add_text_option(app, "--error", o.error, "P", "Of such an answer being wrong")->group("");
  add_text_option(app, "--duration", o.duration, "S", "Of a trial (limit + 10; of a log, to its end)");
  add_text_option(app, "--limit", o.limit, "S", "Success: localized by then (3; kidnap 5)");
  add_text_option(app, "--config", o.filter.config, "C.yaml",
                  "Settings of the filter; --particles N likewise");
  add_text_option(app, "--particles", o.particles, "N", "Instead of the configuration's")->group("");
  add_text_option(app, "--range", o.range, "M", "Of the first LiDAR; --fov DEG likewise, its beams stay");
  add_text_option(app, "--fov", o.fov, "DEG", "Of the first LiDAR; its beams stay")->group("");
  add_text_option(app, "--jobs", o.jobs, "K", "Trials at once (all cores)");
  add_text_option(app, "--samples", o.samples, "F.csv", "Write every scan of every trial there");
  add_text_option(app, "--relations", o.relations, "R.txt",
                  "Or no trials: judge --trajectory T.tum by these");
  add_text_option(app, "--trajectory", o.trajectory, "T.tum", "Of which relations are known")->group("");
  add_text_option(app, "--dataset", o.dataset, "NAME", "Published figures of that log beside")->group("");
  app.add_flag("--families", o.families, "Or kinds of drives (--family NAME; --corrupt)");
  add_text_option(app, "--family", o.family, "NAME", "Of this one only; may come again")->group("");
  add_text_option(app, "--maps", o.maps, "DIR", "Of the maps that come with parloc (maps)")->group("");
  add_text_option(app, "--corrupt", o.corrupt, "K=V,...", "Odometry of the log made worse")->group("");
  add_text_option(app, "--out", o.out, "DIR", "Write report.html and JSON there; --shard I/N: a part");
  shards::add_shard_options(app, o.part);
  app.add_flag("--json", o.json, "The JSON on standard output")->group("");
  app.add_flag("--quiet", o.quiet, "No progress and no tables; --json: the JSON instead");
  app.get_help_ptr()->group("");  // whoever reads the list knows it
  app.footer("docs/evaluate.md");
}

constexpr double kLongest_s = 1e5;
constexpr std::uint64_t kMostTrials = 10000000, kLastSeed = 1000000000;

TrialPlan plan_of(const EvaluateOptions& o, double& limit_s) {
  TrialPlan plan;
  const std::string task = o.task.empty() ? "global" : o.task;
  for (const TrialTask t : {TrialTask::global, TrialTask::kidnap, TrialTask::track})
    if (task == evaluate::name_of(t)) plan.task = t;
  limit_s = plan.task == TrialTask::kidnap ? 5.0 : 3.0;
  if (!o.limit.empty()) limit_s = parse_number("--limit", o.limit, 0.0, kLongest_s);
  plan.duration_s = !o.log.empty() ? 0.0 : limit_s + plan.hold_s;
  if (!o.duration.empty()) plan.duration_s = parse_number("--duration", o.duration, 0.5, kLongest_s);
  return plan;
}

bool asks_for_relations(const EvaluateOptions& o) {
  return !o.relations.empty() || !o.trajectory.empty() || !o.dataset.empty();
}

void check_relations_options(const EvaluateOptions& o) {
  if (o.relations.empty() || o.trajectory.empty())
    throw Error(ErrorKind::usage, "expected --relations R.txt and --trajectory T.tum together");
  const std::pair<const char*, const std::string&> of_trials[] = {{"--scenario", o.scenario},
                                                                  {"--log", o.log},
                                                                  {"--map", o.map},
                                                                  {"--truth", o.truth},
                                                                  {"--task", o.task},
                                                                  {"--trials", o.trials},
                                                                  {"--starts", o.starts},
                                                                  {"--seed", o.seed},
                                                                  {"--bar", o.bar},
                                                                  {"--against", o.against},
                                                                  {"--error", o.error},
                                                                  {"--duration", o.duration},
                                                                  {"--limit", o.limit},
                                                                  {"--config", o.filter.config},
                                                                  {"--particles", o.particles},
                                                                  {"--range", o.range},
                                                                  {"--fov", o.fov},
                                                                  {"--jobs", o.jobs},
                                                                  {"--shard", o.part.shard},
                                                                  {"--samples", o.samples}};
  for (const auto& [name, value] : of_trials)
    if (!value.empty())
      throw Error(
          ErrorKind::usage,
          fmt::format("{} belongs to trials, of which --relations has none: expected one or the other",
                      name));
}

void check_options(const EvaluateOptions& o) {
  const auto usage = [](const char* words) { return Error(ErrorKind::usage, words); };
  if (o.scenario.empty() == o.log.empty())
    throw usage("expected --scenario or --log, and not both; or --relations and --trajectory");
  if (o.log.empty()) {
    if (!o.truth.empty() || !o.starts.empty())
      throw usage("--truth and --starts belong to a log: expected --log");
    return;
  }
  if (o.map.empty() || o.truth.empty()) throw usage("--log: expected --map M.yaml and --truth T.tum as well");
  if (!o.range.empty() || !o.fov.empty()) throw usage("--range and --fov are simulated: expected --scenario");
  if (o.task == "kidnap") throw usage("--task kidnap is simulated: expected --scenario");
}

Scenario scenario_of(const EvaluateOptions& o) {
  Scenario scenario = read_scenario(o.scenario);
  SimulatedLidar& lidar = scenario.lidar;
  if (!o.range.empty()) lidar.range_max_m = parse_number("--range", o.range, lidar.range_min_m + 0.1, 1000.0);
  if (!o.fov.empty()) {
    const double fov_rad = parse_number("--fov", o.fov, 1.0, 360.0) * 3.14159265358979323846 / 180.0;
    lidar.angle_min_rad = -0.5 * fov_rad;
    lidar.angle_step_rad = fov_rad / lidar.beams;
  }
  return scenario;
}

/// Fills in what `e` says of the trials as well.
LogSource source_of(const EvaluateOptions& o, Evaluation& e) {
  e.recorded = !o.log.empty();
  if (!e.recorded) {
    const Scenario scenario = scenario_of(o);
    e.map_path = o.map.empty() ? scenario.localization_map_path : o.map;
    if (e.map_path.empty())
      throw Error(ErrorKind::usage, o.scenario + " names no localization_map: expected --map M.yaml");
    e.wanted = whole_within("--trials", o.trials, 1, kMostTrials, 100);
    return evaluate::simulated_trials(e.plan, scenario, read_map(scenario.map_path), o.scenario);
  }
  const auto starts = whole_within("--starts", o.starts, 1, kMostTrials, 20);
  if (e.first_seed < 1 || e.first_seed > starts)
    throw Error(ErrorKind::usage,
                fmt::format("--seed: expected a start from 1 to {}, got {}", starts, e.first_seed));
  const std::uint64_t left = starts - e.first_seed + 1;
  e.wanted = whole_within("--trials", o.trials, 1, left, left);
  e.map_path = o.map;
  return evaluate::recorded_trials({o.log, o.truth, starts, e.plan.duration_s, log_choice(e.config)});
}

evaluate::Question question_of(const EvaluateOptions& o) {
  const auto usage = [](const char* words) { return Error(ErrorKind::usage, words); };
  evaluate::Question question;
  if (!o.bar.empty()) question.bar = parse_number("--bar", o.bar, 1e-4, 1.0 - 1e-4);
  if (!o.error.empty()) question.error = parse_number("--error", o.error, 1e-6, 0.5);
  if (!o.against.empty()) {
    ConfigOptions options = o.filter;
    options.config = question.other_path = o.against;
    question.other = effective_config(options);
  }
  if (question.bar && question.other)
    throw usage("expected --bar or --against, and not both: one question at a time");
  if (!question.asked() && !o.error.empty()) throw usage("--error: expected --bar or --against as well");
  if (question.asked() && !o.part.shard.empty())
    throw usage("--shard: a part does not see the trials that decide: expected no --bar and no --against");
  return question;
}

/// What decides the results besides the command and the settings.
shards::Inputs inputs_of(const EvaluateOptions& o, const GridMap& map) {
  shards::Inputs inputs = shards::inputs_of(map, {o.scenario, o.log, o.truth});
  if (!o.scenario.empty()) shards::add_scenario(inputs, scenario_of(o));
  return inputs;
}

evaluate::TrialsRequest request_of(const EvaluateOptions& o, const Evaluation& e,
                                   std::vector<std::size_t> items, Progress& progress) {
  evaluate::TrialsRequest request{e.plan,           e.config, e.first_seed,
                                  std::move(items), e.jobs,   !o.samples.empty(),
                                  interrupted,      {},       e.question.other};
  request.progress = [&progress, &e, all = request.items.size()](double fraction, std::size_t finished) {
    progress.update(fraction,
                    fmt::format("{} of {}{} trials", finished, e.question.asked() ? "at most " : "", all));
  };
  return request;
}

int compute_shard(const EvaluateOptions& o, const Evaluation& e, const LogSource& source, const GridMap& map,
                  const shards::ShardHead& head) {
  return shards::compute_shard(
      o.out, head, o.quiet, [&](const std::vector<std::size_t>& items, shards::ShardFile& file) {
        const auto keep = [&](std::size_t item, double took_s, const TrialResult& result) {
          file.add(item, took_s, bytes_of([&](ByteWriter& w) { shards::put_trial(w, result); }));
        };
        Progress progress(o.quiet);
        evaluate::run_trials(request_of(o, e, items, progress), source, map, keep);
      });
}

void compute(const EvaluateOptions& o, Evaluation& e, const LogSource& source, const GridMap& map) {
  Progress progress(o.quiet);
  const Clock::time_point begun = Clock::now();
  if (e.question.asked()) {
    std::vector<std::size_t> items =
        e.recorded ? evaluate::shuffled(e.wanted) : shards::Shard{}.items(e.wanted);
    e.answer.emplace(e.question, e.limit_s);
    evaluate::DecidedTrials decided =
        evaluate::trials_until_decided(request_of(o, e, std::move(items), progress), source, map, *e.answer);
    e.trials = std::move(decided.trials);
    e.dropped = decided.dropped;
    e.trial_s = decided.trial_s;
  } else {
    e.trials = evaluate::run_trials(request_of(o, e, shards::Shard{}.items(e.wanted), progress), source, map,
                                    &e.trial_s);
  }
  e.wall_s = seconds_since(begun);
  if (e.jobs > e.machine.cores)
    e.trial_s *= static_cast<double>(e.machine.cores) / e.jobs;  // they took turns
}

/// The trials, computed here or taken from shards, which must outlive `e`.
void fill_in(const EvaluateOptions& o, Evaluation& e, const LogSource& source, const GridMap& map,
             const shards::Merged* merged) {
  if (merged != nullptr) {
    e.trials = merged->results<TrialResult>(shards::get_trial);
    e.shards = merged->shards();
    e.wall_s = merged->took_s();
    e.trial_s = e.wall_s / static_cast<double>(e.wanted);
  } else {
    compute(o, e, source, map);
  }
  e.interrupted = e.trials.size() < e.wanted && !(e.answer && e.answer->decided());
  e.summary = summarise(e.plan, e.limit_s, e.trials);
}

constexpr const char *kJson = "evaluate.json", *kPage = "report.html";

void write_results(const Evaluation& e, const GridMap& map, OutputFolder* out, const std::string& samples) {
  if (out != nullptr) {
    write_file(out->staged(kJson), [&](const TextSink& sink) { evaluate::write_json(e, sink); });
    replace_file(out->staged(kPage), evaluate::html_page(e, map));
    out->publish();
  }
  if (!samples.empty()) write_file(samples, [&](const TextSink& sink) { evaluate::write_samples(e, sink); });
}

/// Before the long work; what is there stays.
void check_writable(const std::string& path) {
  const bool there = std::filesystem::exists(path);
  if (!std::ofstream(path, std::ios::app))
    throw Error(ErrorKind::output, fmt::format("{}: cannot be written", path));
  if (!there) std::filesystem::remove(path);
}

int judge_by_relations(const EvaluateOptions& o, const std::string& typed) {
  check_relations_options(o);
  return evaluate_relations({o.trajectory, o.relations, o.dataset, o.out, o.json, o.quiet}, typed);
}

Config config_of(const EvaluateOptions& o) {
  return effective_config(o.filter,
                          [&](Config& c) { set_whole_number(c, "particles", "--particles", o.particles); });
}

int jobs_of(const EvaluateOptions& o) {
  const auto cores = std::max<std::uint64_t>(1, std::thread::hardware_concurrency());
  return static_cast<int>(whole_within("--jobs", o.jobs, 1, 256, std::min<std::uint64_t>(cores, 256)));
}

bool asks_for_families(const EvaluateOptions& o) {
  return o.families || !o.family.empty() || !o.corrupt.empty() || !o.maps.empty();
}

/// Of a command line that asks for families.
FamiliesOptions families_options(const EvaluateOptions& o) {
  const std::pair<const char*, const std::string&> drawn[] = {
      {"--scenario", o.scenario}, {"--task", o.task},   {"--starts", o.starts},
      {"--limit", o.limit},       {"--range", o.range}, {"--fov", o.fov}};
  for (const auto& [name, value] : drawn)
    if (!value.empty())
      throw Error(ErrorKind::usage, fmt::format("{} has no meaning for --families, which draw it", name));
  if (!o.bar.empty() || !o.against.empty() || !o.error.empty())
    throw Error(ErrorKind::usage,
                "--bar, --against and --error belong to trials of a scenario or a log, not to --families");
  FamiliesOptions f{o.family, o.maps, o.log, o.map, o.truth, o.corrupt, o.duration};
  f.first_seed = whole_within("--seed", o.seed, 0, kLastSeed, 1);
  f.trials = whole_within("--trials", o.trials, 1, kMostTrials, 20);
  f.jobs = jobs_of(o);
  f.config = config_of(o);
  f.samples = o.samples;
  f.part = o.part;
  f.out = o.out;
  f.json = o.json;
  f.quiet = o.quiet;
  if (!f.samples.empty()) check_writable(f.samples);
  return f;
}

int run(const EvaluateOptions& o, const std::string& typed) {
  shards::check_shard_options(o.part, o.out, o.json);
  if (asks_for_relations(o)) return judge_by_relations(o, typed);
  if (asks_for_families(o)) return evaluate_families(families_options(o), typed);
  // Everything that can be wrong is looked at before the long work.
  check_options(o);
  Evaluation e;
  e.command = deciding_command(typed);
  e.date = date_now();
  e.machine = machine_here();
  e.plan = plan_of(o, e.limit_s);
  e.first_seed = whole_within("--seed", o.seed, 0, kLastSeed, 1);
  e.config = config_of(o);
  e.question = question_of(o);
  const LogSource source = source_of(o, e);
  e.source = source.what;
  e.jobs = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(jobs_of(o)), e.wanted));
  const GridMap map = open_map(e.map_path, log_choice(e.config));
  catch_interrupts();  // before there is a folder to leave behind
  const shards::Parts parts(o.part, typed, e.config, e.wanted, [&] { return inputs_of(o, map); });
  if (parts.shard()) return compute_shard(o, e, source, map, *parts.shard());
  std::unique_ptr<OutputFolder> out;
  if (!o.out.empty()) out = std::make_unique<OutputFolder>(o.out, std::vector<std::string>{kJson, kPage});
  if (!o.samples.empty()) check_writable(o.samples);

  fill_in(o, e, source, map, parts.merged());
  if (e.trials.empty()) {
    fmt::print(stderr, "parloc: interrupted before the first trial was finished, nothing is written\n");
    return kExitInterrupted;
  }
  write_results(e, map, out.get(), o.samples);
  if (o.json) {
    evaluate::write_json(e, print_text);
  } else if (!o.quiet) {
    fmt::print("{}", evaluate::terminal_text(e));
    if (out) fmt::print("{:<18}{} (beside it: {})\n", "report", out->final_path(kPage), kJson);
  }
  return e.interrupted ? kExitInterrupted : 0;
}

}  // namespace

Command add_evaluate_command(CLI::App& program) {
  return add_command<EvaluateOptions>(program, "evaluate",
                                      "Try the localizer many times: how often is it right?", declare, run);
}

}  // namespace parloc::tools
