#include "tools/compare/drives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/io/open_truth.h"
#include "common/simulator/drive.h"
#include "common/simulator/simulator.h"

namespace parloc::tools::compare {
namespace {

/// Its multiples, each without its whole part, spread evenly over 0 to 1 however many there are.
constexpr double kGoldenRatio = 0.61803398874989485;

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

LogSource simulated_drives(const DrivePlan& plan, const Scenario& scenario, const GridMap& map,
                           const std::string& name) {
  const auto log_of = [=](std::uint64_t seed) {
    Scenario seeded = scenario;
    seeded.seed = seed;
    const double whole_s = plan_drive(seeded.path).duration_s();
    SimulatedLog simulated = simulate(seeded, map, [&](double fraction) {
      return plan.duration_s <= 0.0 || fraction * whole_s <= plan.duration_s;
    });
    TrialLog log{std::move(simulated.records), std::move(simulated.truth), 0.0, simulated.hits,
                 simulated.unmapped};
    trim(log, plan, name);
    kidnap_as_planned(log, plan, seed);
    return log;
  };
  return {log_of, fmt::format("{}: its drive, one per seed", name)};
}

LogSource recorded_drives(const DrivePlan& plan, const std::string& log, const LogChoice& choice,
                          const std::string& truth) {
  TrialLog whole;
  std::size_t broken_lines = 0;
  whole.truth = open_truth(truth, choice);
  whole.records = read_whole_log(log, choice, broken_lines);
  trim(whole, plan, truth);
  const auto log_of = [=](std::uint64_t seed) {
    TrialLog kidnapped = whole;
    kidnap_as_planned(kidnapped, plan, seed);
    return kidnapped;
  };
  std::string what = log + ": recorded";
  if (broken_lines > 0)
    what += fmt::format(", {} broken line{} skipped", broken_lines, broken_lines == 1 ? " was" : "s were");
  return {log_of, what};
}

}  // namespace parloc::tools::compare
