#include "tools/compare/drives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/io/open_log.h"
#include "common/simulator/drive.h"
#include "common/simulator/simulator.h"

namespace parloc::tools::compare {
namespace {

/// Its multiples, each without its whole part, spread evenly over 0 to 1 however many there are.
constexpr double kGoldenRatio = 0.61803398874989485;

bool is_scan(const LogRecord& r) {
  return r.kind == RecordKind::scan;
}

/// The true pose at every record; records in between scans have none.
std::vector<std::optional<Pose>> truth_of(const TrialLog& log) {
  std::vector<double> stamps;
  for (const LogRecord& r : log.records) stamps.push_back(r.stamp_s);
  auto poses = truth_at(log.truth, stamps);
  for (std::size_t k = 0; k < poses.size(); ++k)
    if (!is_scan(log.records[k])) poses[k].reset();
  return poses;
}

/// What filters are compared on: from the first scan with a true pose to the end of the plan.
void trim(TrialLog& log, const DrivePlan& plan, const std::string& name) {
  const auto truth = truth_of(log);
  const auto first =
      std::find_if(truth.begin(), truth.end(), [](const auto& pose) { return pose.has_value(); });
  if (first == truth.end())
    throw input_error(name, 0, "expected scans at times at which the true pose is known, found none");
  log.records.erase(log.records.begin(), log.records.begin() + (first - truth.begin()));
  if (plan.duration_s <= 0.0) return;
  const double until_s = log.records.front().stamp_s + plan.duration_s;
  log.records.erase(std::find_if(log.records.begin(), log.records.end(),
                                 [&](const LogRecord& r) { return r.stamp_s > until_s; }),
                    log.records.end());
}

void kidnap_as_planned(TrialLog& log, const DrivePlan& plan, std::uint64_t seed) {
  if (plan.kidnapping) kidnap(log, kidnapped_after_s(*plan.kidnapping, seed), plan.kidnapping->distance_m);
}

class SimulatedDrives : public DriveSource {
 public:
  SimulatedDrives(const DrivePlan& plan, const Scenario& scenario, GridMap map, std::string name)
      : plan_(plan), scenario_(scenario), map_(std::move(map)), name_(std::move(name)) {}

  TrialLog drive(std::uint64_t seed) const override {
    Scenario scenario = scenario_;
    scenario.seed = seed;
    const double whole_s = plan_drive(scenario.path).duration_s();
    SimulatedLog simulated = simulate(scenario, map_, [&](double fraction) {
      return plan_.duration_s <= 0.0 || fraction * whole_s <= plan_.duration_s;
    });
    TrialLog log{std::move(simulated.records), std::move(simulated.truth), 0.0, simulated.hits,
                 simulated.unmapped};
    trim(log, plan_, name_);
    kidnap_as_planned(log, plan_, seed);
    return log;
  }
  std::string what() const override { return fmt::format("{}: its drive, one per seed", name_); }

 private:
  DrivePlan plan_;
  Scenario scenario_;
  GridMap map_;
  std::string name_;
};

class RecordedDrives : public DriveSource {
 public:
  RecordedDrives(const DrivePlan& plan, const std::string& log, const std::string& truth)
      : plan_(plan), name_(log) {
    log_.truth = read_tum(truth);
    const auto reader = open_log(log);
    for (LogRecord record; reader->next(record);) log_.records.push_back(std::move(record));
    broken_lines_ = reader->warnings().broken_lines;
    if (std::none_of(log_.records.begin(), log_.records.end(), is_scan))
      throw input_error(log, 0, "expected at least one scan (FLASER, RLASER or ROBOTLASER1), found none");
    trim(log_, plan, truth);
  }

  TrialLog drive(std::uint64_t seed) const override {
    TrialLog log = log_;
    kidnap_as_planned(log, plan_, seed);
    return log;
  }
  std::string what() const override {
    std::string skipped;
    if (broken_lines_ > 0)
      skipped =
          fmt::format(", {} broken line{} skipped", broken_lines_, broken_lines_ == 1 ? " was" : "s were");
    return name_ + ": recorded" + skipped;
  }

 private:
  DrivePlan plan_;
  TrialLog log_;
  std::size_t broken_lines_ = 0;
  std::string name_;
};

}  // namespace

double kidnapped_after_s(const Kidnapping& k, std::uint64_t seed) {
  const double part = kGoldenRatio * static_cast<double>(seed);
  return k.after_s + (part - std::floor(part)) * (k.until_s - k.after_s);
}

void kidnap(TrialLog& log, double after_s, double distance_m) {
  const auto truth = truth_of(log);
  const double from_s = log.records.front().stamp_s + after_s;
  std::size_t last = 0;  // of the scans before it
  while (last < truth.size() && !(truth[last] && log.records[last].stamp_s >= from_s)) ++last;
  if (last == truth.size())
    throw Error(ErrorKind::input,
                fmt::format("--kidnap: expected a drive of more than {:g} s, this one takes {:g} s", after_s,
                            log.records.back().stamp_s - log.records.front().stamp_s));
  std::size_t next = last + 1;
  const auto far = [&](std::size_t k) {
    return truth[k] &&
           std::hypot(truth[k]->x_m - truth[last]->x_m, truth[k]->y_m - truth[last]->y_m) >= distance_m;
  };
  while (next < truth.size() && !far(next)) ++next;
  if (next >= truth.size())
    throw Error(ErrorKind::input, fmt::format("--kidnap: the drive never gets {:g} m away from where it is "
                                              "after {:g} s",
                                              distance_m, after_s));
  // The odometry goes on from where it was.
  const Pose before = log.records[last].odometry, after = log.records[next].odometry;
  for (std::size_t k = next; k < log.records.size(); ++k)
    log.records[k].odometry = compose(before, relative(log.records[k].odometry, after));
  log.kidnapped_s = log.records[next].stamp_s;
  log.records.erase(log.records.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                    log.records.begin() + static_cast<std::ptrdiff_t>(next));
}

std::unique_ptr<DriveSource> simulated_drives(const DrivePlan& plan, const Scenario& scenario, GridMap map,
                                              const std::string& name) {
  return std::make_unique<SimulatedDrives>(plan, scenario, std::move(map), name);
}
std::unique_ptr<DriveSource> recorded_drives(const DrivePlan& plan, const std::string& log,
                                             const std::string& truth) {
  return std::make_unique<RecordedDrives>(plan, log, truth);
}

}  // namespace parloc::tools::compare
