// parloc log convert: any log as MCAP or CARMEN text.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "common/file/output_file.h"
#include "common/inputs/open_log.h"
#include "common/io/log_notes.h"
#include "common/io/scan_stream.h"
#include "common/model/lidar.h"
#include "tools/log/converted_log.h"
#include "tools/log/log.h"
#include "tools/program/progress.h"
#include "tools/report/text/table.h"

namespace parloc::tools {
namespace {

struct ConvertLogOptions : LogArguments {
  std::string output;
  bool quiet = false;
};

void declare(CLI::App& app, ConvertLogOptions& o) {
  add_log_argument(app, o);
  add_text_option(app, "--output", o.output, "OUT", "OUT.mcap (ROS 2), or OUT.log (CARMEN)")->required();
  app.add_flag("--quiet", o.quiet, "No progress and no summary");
  app.footer("What each of them holds: docs/mcap.md");
}

bool is_mcap_name(const std::string& output) {
  const std::string ending = std::filesystem::path(output).extension().string();
  if (ending == ".mcap") return true;
  if (ending == ".log" || ending == ".clf") return false;
  throw Error(ErrorKind::usage,
              fmt::format("--output: expected a name that ends in .mcap or .log, got '{}'", output));
}

/// What the settings say of a LiDAR is what the written log says of it.
void apply_settings(Scan& scan, const Config& config) {
  const LidarConfig* lidar = find_lidar(config.lidars, scan.sensor);
  if (lidar == nullptr) return;
  const LidarSetup setup = lidar_setup(scan, config.scan, lidar);
  scan.T_base_sensor = setup.T_base_sensor;
  scan.upside_down = setup.upside_down;
  scan.angle_min_rad = setup.angle_min_rad;
  scan.angle_step_rad = setup.angle_step_rad;
  if (!setup.own_bearings) scan.bearings_rad.clear();
  if (lidar->min_range) scan.range_min_m = *lidar->min_range;
  if (lidar->max_range) scan.range_max_m = *lidar->max_range;
  if (lidar->scan_time) {
    scan.scan_time_s = *lidar->scan_time;
    scan.beam_times_s.clear();
  }
}

struct Converted {
  std::size_t scans = 0, readings = 0;
  std::set<std::string> lidars;
};

/// Until the log ends, or somebody ends it.
Converted convert_records(LogReader& log, ConvertedLog& out, const ConvertLogOptions& o,
                          const Config& config) {
  Converted done;
  Progress progress(o.quiet);
  LogRecord record;
  while (!interrupted() && log.next(record)) {
    if (record.kind == RecordKind::scan) apply_settings(record.scan, config);
    try {
      out.write(record);
    } catch (const Error& e) {
      if (e.kind() != ErrorKind::input) throw;
      throw input_error(o.log, record.line, e.what());
    }
    if (record.kind == RecordKind::odometry) {
      ++done.readings;
      continue;
    }
    ++done.scans;
    done.lidars.insert(record.scan.sensor);
    progress.update(log.progress(), fmt::format("{} scans", done.scans));
  }
  return done;
}

std::vector<std::string> warnings_of(const LogWarnings& found, const ConvertedLog& out,
                                     const Config& config) {
  std::vector<std::string> lines;
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) lines.push_back(fmt::format("{} {}", count, what));
  };
  add(found.broken_lines, "broken lines were skipped");
  add(found.backward_stamps, "scans go back in time; what is read of a bag comes in the order of its stamps");
  add(found.beam_count_changes, "scans have another number of beams than the one before");
  for (const std::vector<std::string>& said :
       {open_notes(found.notes, config.lidars), found.messages, out.losses()})
    lines.insert(lines.end(), said.begin(), said.end());
  return lines;
}

int convert(const ConvertLogOptions& o, const std::string&) {
  const bool to_mcap = is_mcap_name(o.output);
  std::error_code error;
  if (std::filesystem::equivalent(o.log, o.output, error) && !error)
    throw Error(ErrorKind::usage, "--output is the log itself");
  const Config config = effective_config(o);
  const std::unique_ptr<LogReader> log = open_log(o.log, log_choice(config));
  expect_writable(o.output);
  FileReplacement file(o.output);
  const auto sink = [&](std::string_view bytes) { file.write(bytes.data(), bytes.size()); };
  const std::unique_ptr<ConvertedLog> out = to_mcap ? convert_to_mcap(sink) : convert_to_carmen(sink);
  catch_interrupts();
  const Converted done = convert_records(*log, *out, o, config);
  if (done.scans == 0 && interrupted()) {
    fmt::print(stderr, "parloc: interrupted before the first scan, nothing is written\n");
    return kExitInterrupted;
  }
  if (done.scans == 0) throw no_scan(o.log, log->warnings());
  out->finish();
  file.commit();
  const int code = interrupted() ? kExitInterrupted : 0;
  if (o.quiet) return code;
  Facts facts;
  add_fact(facts, "log", "{}: {} scans of {} LiDAR{}, {} odometry readings{}", o.log, done.scans,
           done.lidars.size(), done.lidars.size() == 1 ? "" : "s", done.readings,
           code == 0 ? "" : " (interrupted)");
  add_fact(facts, "written", "{}: {:.1f} MB", o.output,
           static_cast<double>(std::filesystem::file_size(o.output, error)) / 1e6);
  for (const std::string& line : warnings_of(log->warnings(), *out, config))
    facts.push_back({"warning", line});
  std::fputs(aligned_text(facts, 12).c_str(), stdout);
  return code;
}

}  // namespace

Command add_log_convert(CLI::App& log) {
  return add_command<ConvertLogOptions>(log, "convert", "Write a log as MCAP or CARMEN", declare, convert);
}

}  // namespace parloc::tools
