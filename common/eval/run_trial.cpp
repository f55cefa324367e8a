#include "common/eval/run_trial.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "common/eval/consistency.h"
#include "common/eval/metrics.h"
#include "common/math/portable64.h"
#include "common/model/lidar.h"

namespace parloc {
namespace {

/// A start that is given is about this exact.
constexpr double kStartSigma_m = 0.1, kStartSigma_rad = 0.05;

std::vector<double> scan_stamps(const std::vector<LogRecord>& records) {
  std::vector<double> stamps;
  for (const LogRecord& record : records)
    if (record.kind == RecordKind::scan) stamps.push_back(record.stamp_s);
  return stamps;
}

/// Gives the localizer the odometry of the log, as far ahead of a scan as its last beam.
class OdometryFeed {
 public:
  OdometryFeed(Localizer& localizer, const std::vector<LogRecord>& records)
      : localizer_(localizer), config_(localizer.filter().config()), records_(records) {}

  void feed_for(std::size_t index) {
    const LogRecord& scan = records_[index];
    const LidarSetup setup =
        lidar_setup(scan.scan, config_.scan, find_lidar(config_.lidars, scan.scan.sensor));
    const double ahead_s = latest_beam_s(scan.scan, setup);
    while (fed_ <= index ||
           (ahead_s > 0.0 && fed_ < records_.size() && records_[fed_ - 1].stamp_s < scan.stamp_s + ahead_s)) {
      localizer_.add_odometry(records_[fed_].stamp_s, records_[fed_].odometry);
      ++fed_;
    }
  }

 private:
  Localizer& localizer_;
  const FilterConfig& config_;
  const std::vector<LogRecord>& records_;
  std::size_t fed_ = 0;
};

TrialSample compare(const LocalizerEstimate& e, double stamp_s, const Pose& truth, bool elsewhere) {
  const double x_m = e.filter.pose.x_m - truth.x_m, y_m = e.filter.pose.y_m - truth.y_m;
  const double heading_rad = wrap64(e.filter.pose.theta_rad - truth.theta_rad);
  TrialSample s;
  s.stamp_s = stamp_s;
  s.position_error_m = std::sqrt(x_m * x_m + y_m * y_m);
  s.heading_error_rad = std::fabs(heading_rad);
  s.probability = e.health.probability;
  s.evidence = e.health.evidence;
  s.log_odds = e.health.log_odds;
  s.share = e.filter.cluster.weight;
  s.state = e.health.state;
  s.searched = e.searched;
  s.x_error_m = x_m;
  s.sigma_x_m = std::sqrt(e.filter.covariance.v[0]);
  s.nees = normalised_error_squared(e.filter.covariance, x_m, y_m, heading_rad);
  if (!elsewhere) return s;
  s.position_error_m = s.heading_error_rad = s.x_error_m = std::numeric_limits<double>::infinity();
  s.nees = std::numeric_limits<double>::quiet_NaN();
  return s;
}

void start(Localizer& localizer, const TrialPlan& plan, const std::optional<PoseGuess>& given,
           const std::optional<Pose>& truth, std::uint64_t seed) {
  localizer.set_seed(seed);
  if (plan.task == TrialTask::global) return localizer.start_anywhere();
  if (given) return localizer.start_at({*given});
  if (!truth) throw Error(ErrorKind::input, "expected the true pose at the first scan, found none near it");
  localizer.start_at({{*truth, kStartSigma_m, kStartSigma_rad, 1.0}});
}

}  // namespace

std::vector<SampleMark> marks_of(const TrialPlan& plan, const std::vector<TrialSample>& samples) {
  std::vector<SampleMark> marks;
  marks.reserve(samples.size());
  for (const TrialSample& s : samples)
    marks.emplace_back(s.probability, is_right(plan, s), s.step_ms, s.searched);
  return marks;
}

std::optional<TrialResult> run_trial(Localizer& localizer, const TrialPlan& plan, const TrialLog& log,
                                     std::uint64_t seed,
                                     const std::function<bool(double fraction)>& keep_going) {
  const std::vector<double> stamps = scan_stamps(log.records);
  if (stamps.empty()) throw Error(ErrorKind::input, "expected at least one scan in the trial's log");
  const std::vector<std::optional<Pose>> truth = truth_at(log.truth, stamps);
  start(localizer, plan, log.start, truth[0], seed);

  TrialResult result;
  result.seed = seed;
  result.begun_s = stamps[0];
  result.hits = log.hits;
  result.unmapped = log.unmapped;
  const double since_s = plan.task == TrialTask::kidnap ? log.kidnapped_s : stamps[0];
  std::optional<Pose> begin;
  OdometryFeed feed(localizer, log.records);
  std::size_t scan = 0;
  for (std::size_t k = 0; k < log.records.size(); ++k) {
    const LogRecord& record = log.records[k];
    if (record.kind != RecordKind::scan) continue;
    const auto begun = std::chrono::steady_clock::now();
    feed.feed_for(k);
    const LocalizerEstimate estimate = localizer.step(record.odometry, record.scan);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begun;
    if (const std::optional<Pose>& where = truth[scan++]) {
      if (!begin && record.stamp_s >= since_s) begin = where;
      TrialSample& sample =
          result.samples.emplace_back(compare(estimate, record.stamp_s, *where, log.elsewhere));
      sample.particles = static_cast<double>(localizer.filter().config().particles);
      sample.step_ms = took.count();
    }
    const double done = static_cast<double>(scan) / static_cast<double>(stamps.size());
    if (keep_going && !keep_going(done)) return std::nullopt;
  }
  if (result.samples.empty())
    throw Error(ErrorKind::input, "expected the true pose at some scans of the trial, found none");
  if (begin) result.start = *begin;
  result.marks = marks_of(plan, result.samples);
  result.searches = localizer.searches();
  result.outcome = judge_trial(plan, result.samples, since_s);
  return result;
}

}  // namespace parloc
