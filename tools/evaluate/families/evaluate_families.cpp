#include "tools/evaluate/families/evaluate_families.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "common/error.h"
#include "common/file/output_file.h"
#include "tools/evaluate/families/drive_source.h"
#include "tools/evaluate/families/families_report.h"
#include "tools/evaluate/families/run_drives.h"
#include "tools/program/commands.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"

namespace parloc::tools {
namespace {

using families::DriveSource;
using families::FamiliesReport;

constexpr const char *kJson = "families.json", *kPage = "report.html";
constexpr double kLongest_s = 1e5;

DriveSource source_of(const FamiliesOptions& o) {
  const auto usage = [](const char* words) { return Error(ErrorKind::usage, words); };
  if (o.log.empty()) {
    if (!o.truth.empty() || !o.map.empty() || !o.corrupt.empty() || !o.duration.empty())
      throw usage(
          "--map, --truth, --corrupt and --duration belong to a recorded log: expected --log as well");
    std::vector<Family> wanted;
    for (const std::string& name : o.families) wanted.push_back(family_named(name));
    if (wanted.empty()) wanted = all_families();
    return families::drawn_drives(o.maps.empty() ? "maps" : o.maps, wanted, o.first_seed, o.trials);
  }
  if (!o.families.empty() || !o.maps.empty())
    throw usage("--family and --maps belong to drawn drives: expected no --log");
  if (o.map.empty() || o.truth.empty()) throw usage("--log: expected --map M.yaml and --truth T.tum as well");
  const double duration_s =
      o.duration.empty() ? 0.0 : parse_number("--duration", o.duration, 0.5, kLongest_s);
  return families::recorded_drives({o.log, o.truth, o.map, o.corrupt, duration_s, log_choice(o.config)},
                                   o.first_seed, o.trials);
}

void run_all(FamiliesReport& report, const DriveSource& source, bool quiet) {
  Progress progress(quiet);
  families::DrivesRequest request{report.config, report.jobs, interrupted, {}};
  request.progress = [&](double fraction, std::size_t finished) {
    progress.update(fraction, fmt::format("{} of {} drives", finished, source.drives));
  };
  const auto begun = std::chrono::steady_clock::now();
  report.drives = families::run_drives(request, source);
  report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  report.interrupted = report.drives.size() < report.wanted;
  report.families = summarise_families(report.drives);
  report.all = summarise_all(report.drives);
}

void write_results(const FamiliesReport& report, OutputFolder* out, const std::string& samples) {
  if (out != nullptr) {
    replace_file(out->staged(kJson), families::json_text(report));
    replace_file(out->staged(kPage), families::html_page(report));
    out->publish();
  }
  if (!samples.empty()) replace_file(samples, families::samples_csv(report));
}

}  // namespace

int evaluate_families(const FamiliesOptions& o, const std::string& typed) {
  FamiliesReport report;
  report.command = typed;
  report.date = date_now();
  report.machine = machine_here();
  report.first_seed = o.first_seed;
  report.config = o.config;
  const DriveSource source = source_of(o);
  report.source = source.what;
  report.wanted = source.drives;
  report.jobs = static_cast<int>(std::min(static_cast<std::size_t>(o.jobs), source.drives));
  catch_interrupts();  // before there is a folder to leave behind
  std::unique_ptr<OutputFolder> out;
  if (!o.out.empty()) out = std::make_unique<OutputFolder>(o.out, std::vector<std::string>{kJson, kPage});

  run_all(report, source, o.quiet);
  if (report.drives.empty()) {
    fmt::print(stderr, "parloc: interrupted before the first drive was finished, nothing is written\n");
    return kExitInterrupted;
  }
  write_results(report, out.get(), o.samples);
  if (o.json) {
    std::fputs(families::json_text(report).c_str(), stdout);
  } else if (!o.quiet) {
    fmt::print("{}", families::terminal_text(report));
    if (out) fmt::print("{:<18}{} (beside it: {})\n", "report", out->final_path(kPage), kJson);
  }
  return report.interrupted ? kExitInterrupted : 0;
}

}  // namespace parloc::tools
