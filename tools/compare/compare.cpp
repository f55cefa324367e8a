// parloc compare: several filters on the same map, drives, truth and seeds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "common/file/output_file.h"
#include "common/inputs/open_map.h"
#include "common/map/map_reader.h"
#include "common/math/angle_units.h"
#include "common/simulator/scenario.h"
#include "tools/compare/comparison.h"
#include "tools/compare/run_bytes.h"
#include "tools/program/commands.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"
#include "tools/program/typed_command.h"
#include "tools/shards/sharding.h"

namespace parloc::tools {
namespace {

using compare::Comparison;

constexpr double kLongestLimit_s = 1e6, kFarthest_m = 1e4;

/// The command line; what was not given is empty.
struct CompareOptions {
  std::string filters, scenario, log, truth, map, config, seeds, seed, duration, sigma, start_error, kidnap,
      kappa, people, jobs, out;
  shards::ShardOptions part;
  ConfigOptions of_log;  ///< Only what add_log_options() adds.
  bool quiet = false;
};

void declare(CLI::App& app, CompareOptions& o) {
  add_text_option(app, "--filters", o.filters, "LIST", "KIND[@PARTICLES][=CONFIG.yaml],... (all kinds)");
  add_text_option(app, "--scenario", o.scenario, "S.yaml", "Simulate its drive, anew for every seed");
  add_log_options(app, o.of_log, o.log, "Or take a recorded log ...");
  add_text_option(app, "--truth", o.truth, "T.tum", "... with its true path");
  add_text_option(app, "--map", o.map, "M.yaml", "Map to localize on (the scenario's)");
  add_text_option(app, "--config", o.config, "C.yaml", "Settings that all filters start from");
  add_text_option(app, "--seeds", o.seeds, "N", "How many (5)");
  add_text_option(app, "--seed", o.seed, "FIRST", "First seed (1)");
  add_text_option(app, "--duration", o.duration, "S", "Only so much of each drive");
  add_text_option(app, "--sigma", o.sigma, "M,RAD", "Spread of the start they are told (0.1,0.05)");
  add_text_option(app, "--start-error", o.start_error, "M,DEG", "How wrong that start is (0,0)");
  add_text_option(app, "--kidnap", o.kidnap, "S[..T],M", "After S (to T) s carry the robot off by M metres");
  add_text_option(app, "--kappa", o.kappa, "M", "Error of the wheels, instead of the scenario's");
  add_text_option(app, "--people", o.people, "N", "Around the robot, instead of the scenario's");
  add_text_option(app, "--jobs", o.jobs, "K", "Seeds at once: spoils the times (1)");
  add_text_option(app, "--out", o.out, "DIR", "compare.json, .md, report.html; --shard I/N: a part");
  shards::add_shard_options(app, o.part);
  app.add_flag("--quiet", o.quiet, "No progress and no tables");
  app.get_help_ptr()->group("");  // whoever reads the list knows it
  app.footer("Kinds: mcl amcl ekf ekf_beams edh naedh ledh gromov pfpf. docs/compare.md");
}

/// "0.5,30": two numbers from 0 on.
std::pair<double, double> two_numbers(const char* option, const std::string& text, double most,
                                      double second_most) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos)
    throw Error(ErrorKind::usage,
                fmt::format("{}: expected two numbers with a comma between, got '{}'", option, text));
  return {parse_number(option, text.substr(0, comma), 0.0, most),
          parse_number(option, text.substr(comma + 1), 0.0, second_most)};
}

/// "60,2" or "60..180,2".
compare::Kidnapping kidnapping_of(const std::string& text) {
  const std::size_t dots = text.find("..");
  const bool single = dots == std::string::npos;
  compare::Kidnapping k;
  std::tie(k.until_s, k.distance_m) =
      two_numbers("--kidnap", single ? text : text.substr(dots + 2), kLongestLimit_s, kFarthest_m);
  k.after_s = single ? k.until_s : parse_number("--kidnap", text.substr(0, dots), 0.0, k.until_s);
  return k;
}

constexpr std::uint64_t kMostSeeds = 10000, kLastPairSeed = 1000000000;

void check_options(const CompareOptions& o) {
  const auto usage = [](const char* words) { return Error(ErrorKind::usage, words); };
  if (o.scenario.empty() == o.log.empty()) throw usage("expected --scenario or --log, and not both");
  if (o.log.empty()) {
    if (!o.truth.empty()) throw usage("--truth belongs to a log: expected --log");
    return;
  }
  if (o.map.empty() || o.truth.empty()) throw usage("--log: expected --map M.yaml and --truth T.tum as well");
  if (!o.kappa.empty() || !o.people.empty())
    throw usage("--kappa and --people are simulated: expected --scenario");
}

compare::DrivePlan plan_of(const CompareOptions& o) {
  compare::DrivePlan plan;
  if (!o.duration.empty()) plan.duration_s = parse_number("--duration", o.duration, 0.5, kLongestLimit_s);
  if (!o.kidnap.empty()) plan.kidnapping = kidnapping_of(o.kidnap);
  return plan;
}

compare::StartPlan start_of(const CompareOptions& o) {
  compare::StartPlan start;
  if (!o.sigma.empty())
    std::tie(start.sigma_xy_m, start.sigma_theta_rad) = two_numbers("--sigma", o.sigma, 1e3, 10.0);
  if (!o.start_error.empty()) {
    const auto [off_m, off_deg] = two_numbers("--start-error", o.start_error, kFarthest_m, 180.0);
    start.off_m = off_m;
    start.off_rad = off_deg * kRadPerDeg;
  }
  return start;
}

Config base_config(const CompareOptions& o) {
  Config config = o.config.empty() ? Config{} : read_config(o.config);
  say_of_log(config, o.of_log);
  return config;
}

compare::Request request_of(const CompareOptions& o) {
  compare::Request r;
  const Config base = base_config(o);
  r.entries = compare::read_entries(o.filters.empty() ? compare::kDefaultFilters : o.filters, base);
  r.start = start_of(o);
  r.first_seed = whole_within("--seed", o.seed, 0, kLastPairSeed, 1);
  r.seeds = whole_within("--seeds", o.seeds, 1, kMostSeeds, 5);
  r.jobs = static_cast<int>(std::min(whole_within("--jobs", o.jobs, 1, 256, 1), std::uint64_t{r.seeds}));
  return r;
}

Scenario scenario_of(const CompareOptions& o) {
  Scenario scenario = read_scenario(o.scenario);
  if (!o.people.empty())
    scenario.clutter.people = static_cast<int>(whole_within("--people", o.people, 0, 1000, 0));
  if (o.kappa.empty()) return scenario;
  if (scenario.odometry.errors != OdometryErrors::wheels)
    throw Error(ErrorKind::usage, "--kappa: expected a scenario whose odometry has form: wheels");
  scenario.odometry.kappa_m = parse_number("--kappa", o.kappa, 0.0, 1.0);
  return scenario;
}

/// Fills in what `c` says of the drives as well.
LogSource source_of(const CompareOptions& o, Comparison& c) {
  c.map_path = o.map;
  if (o.scenario.empty()) return compare::recorded_drives(c.plan, o.log, log_choice(base_config(o)), o.truth);
  const Scenario scenario = scenario_of(o);
  if (c.map_path.empty()) c.map_path = scenario.localization_map_path;
  if (c.map_path.empty())
    throw Error(ErrorKind::usage, o.scenario + " names no localization_map: expected --map M.yaml");
  return compare::simulated_drives(c.plan, scenario, read_map(scenario.map_path), o.scenario);
}

/// The published table, if this is its experiment: the plain drive of the scenario that stands for it.
const compare::PublishedSetting* published_for(const CompareOptions& o, const Comparison& c,
                                               const GridMap& map) {
  if (o.scenario.empty() || c.plan.kidnapping || c.plan.duration_s > 0.0 || c.request.start.off_m > 0.0 ||
      c.request.start.off_rad > 0.0)
    return nullptr;
  const Scenario s = scenario_of(o);
  const bool theirs = s.odometry.errors == OdometryErrors::wheels && s.clutter.people == 0 &&
                      s.path_file.find("tb3_house") != std::string::npos;
  return theirs ? compare::find_published(s.odometry.kappa_m, s.lidar.sigma_range_m, map.resolution_m)
                : nullptr;
}

/// What decides the results besides the command and the settings.
shards::Inputs inputs_of(const CompareOptions& o, const Comparison& c, const GridMap& map) {
  shards::Inputs inputs = shards::inputs_of(map, {o.scenario, o.log, o.truth});
  for (const compare::Entry& entry : c.request.entries)
    inputs.emplace_back("settings of " + entry.label, config_to_yaml(entry.config));
  if (!o.scenario.empty()) shards::add_scenario(inputs, scenario_of(o));
  return inputs;
}

compare::Request request_of(const Comparison& c, std::vector<std::size_t> items, Progress& progress) {
  compare::Request request = c.request;
  request.items = std::move(items);
  request.stop = interrupted;
  request.progress = [&progress, wanted = request.items.size() * request.entries.size()](
                         double fraction, std::size_t finished) {
    progress.update(fraction, fmt::format("{} of {} runs", finished, wanted));
  };
  return request;
}

int compute_shard(const CompareOptions& o, const Comparison& c, const LogSource& source, const GridMap& map,
                  const shards::ShardHead& head) {
  return shards::compute_shard(
      o.out, head, o.quiet, [&](const std::vector<std::size_t>& items, shards::ShardFile& file) {
        const auto keep = [&](std::size_t item, double took_s, const compare::SeedRuns& runs) {
          if (!runs.whole()) return;
          file.add(item, took_s, bytes_of([&](ByteWriter& w) { compare::put_seed(w, runs); }));
        };
        Progress progress(o.quiet);
        compare::run_all(request_of(c, items, progress), source, map, keep);
      });
}

/// The runs, computed here or taken from shards.
void fill_in(const CompareOptions& o, Comparison& c, const LogSource& source, const GridMap& map,
             const shards::Merged* merged) {
  const std::size_t entries = c.request.entries.size();
  if (merged != nullptr) {
    c.outcome = compare::outcome_of(entries, merged->results<compare::SeedRuns>([&](ByteReader& r) {
      return compare::get_seed(r, entries);
    }));
    c.shards = merged->shards();
    c.wall_s = merged->took_s();
  } else {
    Progress progress(o.quiet);
    const Clock::time_point begun = Clock::now();
    std::map<std::size_t, compare::SeedRuns> by_seed;
    std::mutex mutex;
    compare::run_all(request_of(c, shards::Shard{}.items(c.request.seeds), progress), source, map,
                     [&](std::size_t item, double, compare::SeedRuns runs) {
                       const std::lock_guard lock(mutex);
                       by_seed.emplace(item, std::move(runs));
                     });
    c.wall_s = seconds_since(begun);
    std::vector<compare::SeedRuns> seeds;
    for (auto& [item, runs] : by_seed) seeds.push_back(std::move(runs));
    c.outcome = compare::outcome_of(entries, std::move(seeds));
  }
  c.interrupted = c.outcome.finished < c.request.seeds * entries;
  for (const auto& runs : c.outcome.runs) c.summaries.push_back(compare::summarise(runs));
}

/// Without any, every filter would be one that drives blind.
void check_walls(const GridMap& map, const std::string& path) {
  if (std::find(map.cells.begin(), map.cells.end(), Cell::occupied) == map.cells.end())
    throw input_error(path, 0, "expected a map with walls, found no occupied cell");
}

constexpr const char* kCompareJson = "compare.json";
constexpr const char* kCompareMarkdown = "compare.md";
constexpr const char* kComparePage = "report.html";

int run(const CompareOptions& o, const std::string& typed) {
  // Everything that can be wrong is looked at before the long work.
  check_options(o);
  shards::check_shard_options(o.part, o.out, false);
  Comparison c;
  c.command = deciding_command(typed);
  c.date = date_now();
  c.machine = machine_here();
  c.plan = plan_of(o);
  c.request = request_of(o);
  const LogSource source = source_of(o, c);
  c.source = source.what;
  const GridMap map = open_map(c.map_path, log_choice(base_config(o)));
  check_walls(map, c.map_path);
  c.published = published_for(o, c, map);
  catch_interrupts();
  const shards::Parts parts(o.part, typed, base_config(o), c.request.seeds,
                            [&] { return inputs_of(o, c, map); });
  if (parts.shard()) return compute_shard(o, c, source, map, *parts.shard());
  std::unique_ptr<OutputFolder> out;
  if (!o.out.empty())
    out = std::make_unique<OutputFolder>(
        o.out, std::vector<std::string>{kCompareJson, kCompareMarkdown, kComparePage});

  fill_in(o, c, source, map, parts.merged());
  if (c.outcome.finished == 0) {
    fmt::print(stderr, "parloc: interrupted before the first run was finished, nothing is written\n");
    return kExitInterrupted;
  }
  if (out) {
    replace_file(out->staged(kCompareJson), compare::json_text(c));
    replace_file(out->staged(kCompareMarkdown), compare::markdown_text(c));
    replace_file(out->staged(kComparePage), compare::html_page(c));
    out->publish();
  }
  if (!o.quiet) {
    fmt::print("{}", compare::terminal_text(c));
    if (out)
      fmt::print("{:<12}{} (beside it: {}, {})\n", "report", out->final_path(kComparePage), kCompareJson,
                 kCompareMarkdown);
  }
  return c.interrupted ? kExitInterrupted : 0;
}

}  // namespace

Command add_compare_command(CLI::App& program) {
  return add_command<CompareOptions>(program, "compare",
                                     "Several filters on the same drives: which is how good?", declare, run);
}

}  // namespace parloc::tools
