#include "tools/evaluate/families/evaluate_families.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file/output_file.h"
#include "common/inputs/open_map.h"
#include "tools/evaluate/families/drive_bytes.h"
#include "tools/evaluate/families/drive_source.h"
#include "tools/evaluate/families/families_report.h"
#include "tools/evaluate/families/run_drives.h"
#include "tools/program/commands.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/program/progress.h"
#include "tools/program/typed_command.h"
#include "tools/report/machine/statistics.h"
#include "tools/shards/shard.h"

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

/// What decides the results besides the command and the settings.
shards::Inputs inputs_of(const FamiliesOptions& o) {
  if (o.log.empty()) {
    const std::string folder = o.maps.empty() ? "maps" : o.maps;
    return {{folder, shards::file_digest(folder)}};
  }
  return shards::inputs_of(open_map(o.map, log_choice(o.config)), {o.log, o.truth});
}

families::DrivesRequest request_of(const FamiliesOptions& o, const FamiliesReport& report,
                                   std::vector<std::size_t> items, Progress& progress) {
  families::DrivesRequest request{report.config,      std::move(items), report.jobs,
                                  !o.samples.empty(), interrupted,      {}};
  request.progress = [&progress, all = request.items.size()](double fraction, std::size_t finished) {
    progress.update(fraction, fmt::format("{} of {} drives", finished, all));
  };
  return request;
}

int compute_shard(const FamiliesOptions& o, const FamiliesReport& report, const DriveSource& source,
                  const shards::ShardHead& head) {
  return shards::compute_shard(
      o.out, head, o.quiet, [&](const std::vector<std::size_t>& items, shards::ShardFile& file) {
        const auto keep = [&](std::size_t item, double took_s, const DriveResult& result) {
          file.add(item, took_s, bytes_of([&](ByteWriter& w) { families::put_drive(w, result); }));
        };
        Progress progress(o.quiet);
        families::run_drives(request_of(o, report, items, progress), source, keep);
      });
}

/// The drives, computed here or taken from shards, which must outlive `report`.
void fill_in(const FamiliesOptions& o, FamiliesReport& report, const DriveSource& source,
             const shards::Merged* merged) {
  if (merged != nullptr) {
    report.drives = merged->results<DriveResult>(families::get_drive);
    report.shards = merged->shards();
    report.wall_s = merged->took_s();
  } else {
    Progress progress(o.quiet);
    const Clock::time_point begun = Clock::now();
    report.drives =
        families::run_drives(request_of(o, report, shards::Shard{}.items(source.drives), progress), source);
    report.wall_s = seconds_since(begun);
  }
  report.interrupted = report.drives.size() < report.wanted;
  FamilySummaries summaries = summarise_families(report.drives);
  report.all = std::move(summaries.all);
  report.families = std::move(summaries.families);
}

void write_results(const FamiliesReport& report, OutputFolder* out, const std::string& samples) {
  if (out != nullptr) {
    write_file(out->staged(kJson), [&](const TextSink& sink) { families::write_json(report, sink); });
    replace_file(out->staged(kPage), families::html_page(report));
    out->publish();
  }
  if (!samples.empty())
    write_file(samples, [&](const TextSink& sink) { families::write_samples(report, sink); });
}

}  // namespace

int evaluate_families(const FamiliesOptions& o, const std::string& typed) {
  FamiliesReport report;
  report.command = deciding_command(typed);
  report.date = date_now();
  report.machine = machine_here();
  report.first_seed = o.first_seed;
  report.config = o.config;
  const DriveSource source = source_of(o);
  report.source = source.what;
  report.wanted = source.drives;
  report.jobs = static_cast<int>(std::min(static_cast<std::size_t>(o.jobs), source.drives));
  catch_interrupts();  // before there is a folder to leave behind
  const shards::Parts parts(o.part, typed, o.config, source.drives, [&] { return inputs_of(o); });
  if (parts.shard()) return compute_shard(o, report, source, *parts.shard());
  std::unique_ptr<OutputFolder> out;
  if (!o.out.empty()) out = std::make_unique<OutputFolder>(o.out, std::vector<std::string>{kJson, kPage});

  fill_in(o, report, source, parts.merged());
  if (report.drives.empty()) {
    fmt::print(stderr, "parloc: interrupted before the first drive was finished, nothing is written\n");
    return kExitInterrupted;
  }
  write_results(report, out.get(), o.samples);
  if (o.json) {
    families::write_json(report, print_text);
  } else if (!o.quiet) {
    fmt::print("{}", families::terminal_text(report));
    if (out) fmt::print("{:<18}{} (beside it: {})\n", "report", out->final_path(kPage), kJson);
  }
  return report.interrupted ? kExitInterrupted : 0;
}

}  // namespace parloc::tools
