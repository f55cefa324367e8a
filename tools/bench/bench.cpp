// parloc bench: filter steps on this machine beside the published times.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/file/output_file.h"
#include "common/filter/stages.h"
#include "common/model/beams.h"
#include "tools/bench/forms.h"
#include "tools/bench/plan.h"
#include "tools/bench/published.h"
#include "tools/bench/steps/scenes.h"
#include "tools/program/commands.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"

namespace parloc::tools {
namespace {

using bench::Plan;
using bench::Results;

/// The command line; what was not given is empty.
struct BenchOptions {
  std::string scene, cloud, algorithm, threads, max_particles, max_beams, seconds, maps;
  std::string out = "parloc_bench";
  bool scale = false, quick = false, json = false, quiet = false;
};

void declare(CLI::App& app, BenchOptions& o) {
  app.add_flag("--scale", o.scale, "Instead: to 16 M particles, 1080 beams, all threads");
  app.add_flag("--quick", o.quick, "Rough, within 20 s");
  add_text_option(app, "--scene", o.scene, "A,B", "no_hit, hall, hall_obstacles, office");
  add_text_option(app, "--cloud", o.cloud, "A,B", "tracking, global (tracking)");
  add_text_option(app, "--algorithm", o.algorithm, "A,B", "paz2012, parloc (both)");
  add_text_option(app, "--threads", o.threads, "K", "Instead of all cores");
  add_text_option(app, "--max-particles", o.max_particles, "N", "Leave out what is larger");
  add_text_option(app, "--max-beams", o.max_beams, "B", "Leave out what has more");
  add_text_option(app, "--seconds", o.seconds, "S", "Time per row (1)");
  add_text_option(app, "--maps", o.maps, "DIR", "Folder of the maps that come with parloc");
  add_text_option(app, "--out", o.out, "DIR", "Folder for the results (parloc_bench)");
  app.add_flag("--json", o.json, "Print bench.json alone");
  app.add_flag("--quiet", o.quiet, "No progress and no tables");
  app.footer(
      "Prints the three tables of Paz et al. 2012 beside this machine's times, and\n"
      "writes bench.json, bench.md, bench.html. What it all means: docs/bench.md");
}

/// The words of a list with commas, each of which must be one of `names`.
template <std::size_t n>
std::vector<std::size_t> choices(const char* option, const std::string& text,
                                 const std::array<const char*, n>& names) {
  std::vector<std::size_t> chosen;
  for (const std::string& word : split_at_commas(text)) {
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end()) {
      std::string all;
      for (const char* name : names) all += (all.empty() ? "" : ", ") + std::string(name);
      throw Error(ErrorKind::usage, fmt::format("{}: expected names out of {}, got '{}'", option, all, word));
    }
    const auto index = static_cast<std::size_t>(found - names.begin());
    if (std::find(chosen.begin(), chosen.end(), index) == chosen.end()) chosen.push_back(index);
  }
  return chosen;
}

Plan plan_of(const BenchOptions& o) {
  Plan plan;
  const std::string scenes = !o.scene.empty() ? o.scene
                             : o.scale        ? "hall_obstacles"
                                              : "no_hit,hall_obstacles";
  for (const std::size_t k : choices("--scene", scenes, bench::kSceneNames))
    plan.scenes.emplace_back(bench::kSceneNames[k]);
  for (const std::size_t k : choices("--cloud", o.cloud.empty() ? "tracking" : o.cloud, bench::kCloudNames))
    plan.clouds.push_back(static_cast<bench::Cloud>(k));
  std::string algorithms = o.algorithm.empty() ? "paz2012,parloc" : o.algorithm;
  const std::string former = "published";  // still understood
  for (std::size_t at = 0; (at = algorithms.find(former, at)) != std::string::npos;)
    algorithms.replace(at, former.size(), "paz2012");
  for (const std::size_t k : choices("--algorithm", algorithms, bench::kAlgorithmNames))
    plan.algorithms.push_back(static_cast<bench::Algorithm>(k));
  if (o.scale && !o.algorithm.empty() && o.algorithm != "parloc")
    throw Error(ErrorKind::usage,
                "--scale measures parloc only: its time grows in proportion, that of paz2012 does not");
  plan.quick = o.quick;
  plan.threads = static_cast<int>(whole_within("--threads", o.threads, 0, 1024, 0));
  const std::uint64_t least = o.scale ? 1024 : bench::kPublishedParticles.front();
  plan.max_particles = static_cast<std::int64_t>(
      whole_within("--max-particles", o.max_particles, least, kMaxParticles, kMaxParticles));
  plan.max_beams = static_cast<int>(
      whole_within("--max-beams", o.max_beams, bench::kPublishedBeams.front(), kMaxBeams, kMaxBeams));
  return plan;
}

bench::TimingRules rules_of(const BenchOptions& o) {
  bench::TimingRules rules = o.quick ? bench::quick_rules() : bench::TimingRules{};
  if (o.seconds.empty()) return rules;
  const double seconds = parse_number("--seconds", o.seconds, 0.001, 3600.0);
  rules.seconds = seconds;
  rules.warm_up_seconds = std::min(rules.warm_up_seconds, seconds);
  rules.long_seconds = std::max(rules.long_seconds, seconds);
  return rules;
}

/// What --quick may take, so that the last row and the files are done within 20 s.
constexpr std::chrono::seconds kQuickTime{13};

void measure(const Plan& plan, const std::vector<bench::Scene>& scenes, bool quiet, Clock::time_point begun,
             Results& results) {
  catch_interrupts();
  Progress progress(quiet);
  bench::Control control;
  control.stop = interrupted;
  control.progress = [&](double fraction, std::string_view what) { progress.update(fraction, what); };
  if (plan.quick) control.deadline = begun + kQuickTime;
  (results.scale ? bench::measure_scale : bench::measure_tables)(plan, scenes, control, results);
}

constexpr const char* kBenchJson = "bench.json";
constexpr const char* kBenchMarkdown = "bench.md";
constexpr const char* kHtml = "bench.html";

int run(const BenchOptions& o, const std::string& typed) {
  const Clock::time_point begun = Clock::now();
  // Everything that can be wrong is looked at before the long work.
  const Plan plan = plan_of(o);
  Results results;
  results.rules = rules_of(o);
  std::vector<bench::Scene> scenes;
  const bool reads = plan.scenes != std::vector<std::string>{"no_hit"};
  const std::string maps = reads || !o.maps.empty() ? bench::find_maps_folder(o.maps) : "";
  for (const std::string& name : plan.scenes) scenes.push_back(bench::make_scene(name, maps));
  for (const bench::Scene& scene : scenes) results.scenes.push_back({scene.name, scene.what});
  OutputFolder out(o.out, {kBenchJson, kBenchMarkdown, kHtml});

  results.scale = o.scale;
  results.quick = o.quick;
  results.command = typed;
  results.date = date_now();
  results.machine = machine_here();
  measure(plan, scenes, o.quiet, begun, results);
  if (results.interrupted && results.rows.empty()) {
    fmt::print(stderr, "parloc: interrupted before the first row, nothing is written\n");
    return kExitInterrupted;
  }

  const std::string json = bench::json_text(results);
  replace_file(out.staged(kBenchJson), json);
  replace_file(out.staged(kBenchMarkdown), bench::markdown_page(results));
  replace_file(out.staged(kHtml), bench::html_page(results));
  out.publish();
  if (o.json) {
    std::fputs(json.c_str(), stdout);
  } else if (!o.quiet) {
    fmt::print("{}{:<9}{} (beside it: {}, {})\n", bench::terminal_page(results), "page",
               out.final_path(kHtml), kBenchMarkdown, kBenchJson);
  }
  if (results.interrupted) return kExitInterrupted;
  if (results.failed)
    throw Error(ErrorKind::internal, "some rows broke off (" + results.skipped.front().why +
                                         "); the others are in " + out.final_path(kBenchJson));
  return 0;
}

}  // namespace

Command add_bench_command(CLI::App& program) {
  return add_command<BenchOptions>(program, "bench", "Measure filter steps beside the published times",
                                   declare, run);
}

}  // namespace parloc::tools
