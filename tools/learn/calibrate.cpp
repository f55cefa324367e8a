#include "tools/learn/calibrate.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/calibrate/calibration.h"
#include "common/file/output_file.h"
#include "common/inputs/open_log.h"
#include "common/io/scan_stream.h"
#include "tools/learn/calibration_text.h"
#include "tools/program/commands.h"
#include "tools/program/note_teller.h"
#include "tools/program/output_folder.h"
#include "tools/program/progress.h"

namespace parloc::tools {
namespace {

constexpr const char* kSettings = "calibration.yaml";
constexpr const char* kCalibrationJson = "calibration.json";
/// Of the time that it takes.
constexpr double kReading = 0.6;

LogCalibration calibrate_records(const CalibrateOptions& o, const Config& config) {
  const std::unique_ptr<LogReader> log = open_log(o.log, log_choice(config));
  ScanMotions motions(config.scan, config.lidars);
  Progress progress(o.quiet);
  NoteTeller notes(o.log, config.lidars, o.quiet);
  for (LogRecord record; !interrupted() && log->next(record);) {
    notes.tell(log->warnings());
    motions.add(record);
    if (record.kind == RecordKind::scan) progress.update(kReading * log->progress());
  }
  if (motions.scans() == 0 && !interrupted()) throw no_scan(o.log, log->warnings());
  return calibrate(motions, config.motion.form == MotionForm::omni, [&](double fraction) {
    progress.update(kReading + (1.0 - kReading) * fraction);
    return !interrupted();
  });
}

}  // namespace

int calibrate_log(const CalibrateOptions& o, const Config& config, const std::string& typed) {
  const CalibrationParts parts = calibration_parts(o.what);
  OutputFolder out(o.out, {kSettings, kCalibrationJson});
  catch_interrupts();
  const LogCalibration found = calibrate_records(o, config);
  const std::string settings = calibration_settings(found, parts, config.motion, typed);
  nlohmann::ordered_json json = calibration_json(found, parts, config.motion);
  json["log"] = o.log;
  json["interrupted"] = interrupted();
  replace_file(out.staged(kSettings), settings);
  replace_file(out.staged(kCalibrationJson), json.dump(2) + "\n");
  out.publish();
  if (!o.quiet) fmt::print(stderr, "{}", calibration_table(found, parts, config.motion));
  std::fputs(o.json ? (json.dump(2) + "\n").c_str() : settings.c_str(), stdout);
  if (!o.quiet)
    fmt::print(stderr, "{:<16}{} (beside it: {})\n", "results", out.final_path(kSettings), kCalibrationJson);
  return interrupted() ? kExitInterrupted : 0;
}

}  // namespace parloc::tools
