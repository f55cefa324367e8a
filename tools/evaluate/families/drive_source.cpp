#include "tools/evaluate/families/drive_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/io/open_log.h"
#include "common/io/open_map.h"
#include "common/io/open_truth.h"

namespace parloc::tools::families {
namespace {

/// What all recorded drives share.
struct RecordedLog {
  std::vector<LogRecord> records;
  Trajectory truth;
  std::shared_ptr<const GridMap> map;
  OdometryCorruption corruption;
};

/// From the first scan whose true pose is known, for `duration_s`.
std::vector<LogRecord> read_records(const RecordedDrives& plan, const Trajectory& truth) {
  std::vector<LogRecord> records;
  const auto log = open_log(plan.log, plan.choice);
  for (LogRecord record; log->next(record);) records.push_back(std::move(record));
  std::vector<double> stamps;
  for (const LogRecord& r : records) stamps.push_back(r.stamp_s);
  const auto known = truth_at(truth, stamps);
  std::size_t first = 0;
  while (first < records.size() && (records[first].kind != RecordKind::scan || !known[first])) ++first;
  if (first == records.size())
    throw input_error(plan.truth, 0,
                      fmt::format("expected poses at the times of scans of {}, found none", plan.log));
  records.erase(records.begin(), records.begin() + static_cast<std::ptrdiff_t>(first));
  if (plan.duration_s > 0.0) {
    const double until_s = records[0].stamp_s + plan.duration_s;
    const auto end =
        std::find_if(records.begin(), records.end(), [&](const LogRecord& r) { return r.stamp_s > until_s; });
    records.erase(end, records.end());
  }
  return records;
}

}  // namespace

DriveSource drawn_drives(const std::string& folder, const std::vector<Family>& families,
                         std::uint64_t first_seed, std::size_t trials) {
  const auto places = std::make_shared<const Places>(folder);
  DriveSource source;
  source.what =
      fmt::format("{} families, {} drives of each, on the maps of {}", families.size(), trials, folder);
  source.drives = families.size() * trials;
  source.prepare = [=](std::size_t index) {
    const DrawnDrive drive = draw_drive(families[index / trials], first_seed + index % trials);
    PreparedDrive prepared;
    prepared.result.family = name_of(drive.family);
    prepared.result.place = place_name(drive.place);
    if (drive.localized_on != drive.place) prepared.result.place += " on " + place_name(drive.localized_on);
    prepared.result.seed = drive.seed;
    prepared.result.parameters = parameters_of(drive);
    prepared.trial = make_trial(drive, *places);
    return prepared;
  };
  return source;
}

DriveSource recorded_drives(const RecordedDrives& plan, std::uint64_t first_seed, std::size_t trials) {
  auto log = std::make_shared<RecordedLog>();
  log->corruption = corruption_from_text(plan.corrupt);
  log->truth = open_truth(plan.truth, plan.choice);
  log->map = std::make_shared<const GridMap>(open_map(plan.map, plan.choice));
  log->records = read_records(plan, log->truth);
  DriveSource source;
  const std::string how = plan.corrupt.empty() ? "as recorded" : plan.corrupt;
  source.what = fmt::format("{} on {}, odometry: {}", plan.log, plan.map, how);
  source.drives = trials;
  source.prepare = [=](std::size_t index) {
    PreparedDrive prepared;
    prepared.result.family = how;
    prepared.result.place = plan.log;
    prepared.result.seed = first_seed + index;
    prepared.trial.plan.task = TrialTask::track;
    prepared.trial.map = log->map;
    prepared.trial.log.truth = log->truth;
    prepared.trial.log.records = log->records;
    prepared.trial.events =
        corrupt_odometry(prepared.trial.log.records, log->corruption, prepared.result.seed);
    return prepared;
  };
  return source;
}

}  // namespace parloc::tools::families
