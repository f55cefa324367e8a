#include "tools/evaluate/trial_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/io/open_log.h"
#include "common/simulator/wander.h"

namespace parloc::tools::evaluate {
namespace {

constexpr double kClearance_m = 0.3;  // of the drives from walls

class SimulatedTrials : public TrialSource {
 public:
  SimulatedTrials(const TrialPlan& plan, const Scenario& scenario, GridMap map, std::string name)
      : plan_(plan),
        scenario_(scenario),
        map_(std::move(map)),
        area_(map_, kClearance_m),
        name_(std::move(name)) {}

  TrialLog trial(std::uint64_t seed) const override {
    return simulate_trial(plan_, scenario_, map_, area_, seed);
  }
  std::string what() const override {
    const SimulatedLidar& l = scenario_.lidar;
    return fmt::format("{}: random drives over {:.0f} m2 of {}; LiDAR {:.0f} degrees, {} beams, {:g} m",
                       name_, area_.area_m2(), scenario_.map_path,
                       l.angle_step_rad * l.beams * 180.0 / 3.14159265358979, l.beams, l.range_max_m);
  }

 private:
  TrialPlan plan_;
  Scenario scenario_;
  GridMap map_;
  WanderArea area_;
  std::string name_;
};

class RecordedTrials : public TrialSource {
 public:
  explicit RecordedTrials(const RecordedPlan& plan) : plan_(plan), truth_(read_tum(plan.truth)) {
    const auto log = open_log(plan.log);
    for (LogRecord record; log->next(record);) records_.push_back(std::move(record));
    std::vector<double> stamps;
    for (const LogRecord& r : records_)
      if (r.kind == RecordKind::scan) stamps.push_back(r.stamp_s);
    if (stamps.empty())
      throw input_error(plan.log, 0,
                        "expected at least one scan (FLASER, RLASER or ROBOTLASER1), found none");
    first_s_ = stamps.front();
    span_s_ = *std::max_element(stamps.begin(), stamps.end()) - first_s_;
    const auto known = truth_at(truth_, stamps);
    if (std::none_of(known.begin(), known.end(), [](const auto& pose) { return pose.has_value(); }))
      throw input_error(plan.truth, 0,
                        fmt::format("expected poses at the times of {}, found none", plan.log));
  }

  TrialLog trial(std::uint64_t seed) const override {
    const double from_s =
        first_s_ + span_s_ * static_cast<double>(seed - 1) / static_cast<double>(plan_.starts);
    const auto begins = [&](const LogRecord& r) { return r.kind == RecordKind::scan && r.stamp_s >= from_s; };
    const auto begin = std::find_if(records_.begin(), records_.end(), begins);
    TrialLog log;
    log.truth = truth_;
    const double until_s = begin->stamp_s + plan_.duration_s;
    for (auto record = begin; record != records_.end(); ++record) {
      if (plan_.duration_s > 0.0 && record->stamp_s > until_s) break;
      log.records.push_back(*record);
    }
    return log;
  }
  std::string what() const override {
    return fmt::format("{}: {} starts spread over {:.0f} s", plan_.log, plan_.starts, span_s_);
  }

 private:
  RecordedPlan plan_;
  Trajectory truth_;
  std::vector<LogRecord> records_;
  double first_s_ = 0.0, span_s_ = 0.0;
};

}  // namespace

std::unique_ptr<TrialSource> simulated_trials(const TrialPlan& plan, const Scenario& scenario, GridMap map,
                                              const std::string& name) {
  return std::make_unique<SimulatedTrials>(plan, scenario, std::move(map), name);
}
std::unique_ptr<TrialSource> recorded_trials(const RecordedPlan& plan) {
  return std::make_unique<RecordedTrials>(plan);
}

}  // namespace parloc::tools::evaluate
