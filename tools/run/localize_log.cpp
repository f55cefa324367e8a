#include "tools/run/localize_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "common/config/config.h"
#include "common/error.h"
#include "common/io/scan_stream.h"
#include "common/math/quantile.h"
#include "common/model/beams.h"
#include "common/model/lidar.h"
#include "tools/report/even_sample.h"
#include "tools/report/machine/statistics.h"
#include "tools/run/tracker.h"

namespace parloc::tools {
namespace {

/// With --strict: throws at the first thing that would else be counted and reported.
class StrictCheck {
 public:
  StrictCheck(bool strict, const std::string& log_name) : strict_(strict), log_name_(log_name) {}

  /// After each record, and at the end of the log.
  void check_log(const LogWarnings& now, std::size_t line) {
    if (!strict_) return;
    const char* what = now.broken_lines > 0         ? "a broken line"
                       : now.backward_stamps > 0    ? "time runs backwards"
                       : now.beam_count_changes > 0 ? "the number of beams changed"
                                                    : nullptr;
    if (what == nullptr) return;
    // The reader's own words name the line of the trouble, which `line` may have passed.
    const std::string tail = " (--strict)";
    if (!now.messages.empty()) throw Error(ErrorKind::input, now.messages.back() + tail);
    throw input_error(log_name_, line, what + tail);
  }

  /// After each step.
  void check_step(const ParticleFilter& filter, std::size_t line) const {
    if (!strict_) return;
    const BeamCounts beams = filter.beam_counts();
    for (const RejectReason& reason : kRejectReasons) {
      if (beams.*reason.count > 0)
        throw input_error(
            log_name_, line,
            fmt::format("{} {} ranges in a scan (--strict)", beams.*reason.count, reason.strict));
    }
    if (filter.odometry_jumps() > 0) {
      throw input_error(log_name_, line, fmt::format("odometry jumps: no robot moves so (--strict)"));
    }
  }

  /// At the end of the log.
  void check_whole(const ParticleFilter& filter, const ScanTimes& times) const {
    if (!strict_) return;
    const std::string unused = unused_lidars(filter.config(), filter.lidars_used());
    for (const std::string& trouble : {unused, times.trouble()})
      if (!trouble.empty()) throw input_error(log_name_, 0, trouble + " (--strict)");
  }

 private:
  bool strict_;
  const std::string& log_name_;
};

StartPose start_of(const LocalizeRequest& request, double first_stamp_s) {
  if (request.start) return *request.start;
  if (!request.truth.empty()) return start_from_truth(request.truth, first_stamp_s, request.config);
  throw Error(ErrorKind::usage, "no start pose: give --init x,y,theta, --init global, or --truth");
}

StepRecord step_record(const Estimate& estimate, double stamp_s, double step_ms) {
  const double* variance = estimate.covariance.v;
  StepRecord step;
  step.stamp_s = stamp_s;
  step.n_eff = estimate.n_eff;
  step.sigma_x_m = std::sqrt(variance[0]);
  step.sigma_y_m = std::sqrt(variance[4]);
  step.sigma_theta_rad = std::sqrt(variance[8]);
  step.step_ms = step_ms;
  step.resampled = estimate.resampled;
  step.lost = estimate.lost;
  step.particles = static_cast<double>(estimate.particles);
  step.p_injected = estimate.p_injected;
  return step;
}

Config filter_config(const LocalizeRequest& request) {
  Config config = request.config;
  if (request.odometry_only) config.estimate.mode = EstimateMode::mean;
  return config;
}

/// The scan's points are the ends of the beams that hit something, seen from the estimate; map frame.
Snapshot snapshot_of(const ParticleFilter& filter, const Pose& estimate, const Scan& scan) {
  Snapshot snapshot{scan.stamp_s, estimate, filter.particles(Snapshot::max_particles), {}};
  const double c = std::cos(estimate.theta_rad), s = std::sin(estimate.theta_rad);
  for (const EndPoint& p : filter.end_points(scan)) {
    snapshot.scan_points.push_back({static_cast<float>(estimate.x_m + c * p.x_m - s * p.y_m),
                                    static_cast<float>(estimate.y_m + s * p.x_m + c * p.y_m)});
  }
  return snapshot;
}

/// Collects the run's results step by step.
class Run {
 public:
  Run(const GridMap& map, const LocalizeRequest& request, const LogRecord& first)
      : tracker_(filter_config(request), map, request.config.localize.health && !request.odometry_only),
        start_(start_of(request, first.stamp_s)),
        request_(request) {
    result_.odometry_only = request.odometry_only;
    result_.config = filter_config(request);
    tracker_.start(start_);
    T_map_odometry_ = compose(start_.pose, inverse(first.odometry));
    earliest_s_ = latest_s_ = first.stamp_s;
    begun_ = Clock::now();
  }

  void step(const LogRecord& record, ScanStream& scans) {
    const Clock::time_point begun = Clock::now();
    scans.pass_odometry(
        [&](const StampedPose& reading) { tracker_.add_odometry(reading.stamp_s, reading.pose); });
    last_scan_ = record.scan;
    if (result_.odometry_only) last_scan_.ranges_m.clear();  // a scan without beams moves the particles only
    LocalizerEstimate judged = tracker_.step(record.odometry, last_scan_);
    const Estimate& estimate = judged.filter;
    const double step_ms = 1e3 * seconds_since(begun);
    result_.trajectory.push_back({record.stamp_s, estimate.pose});
    if (start_.known())
      result_.odometry.push_back({record.stamp_s, compose(T_map_odometry_, record.odometry)});
    result_.covariances.push_back({record.stamp_s, estimate.covariance});
    result_.steps.push_back(step_record(estimate, record.stamp_s, step_ms));
    if (tracker_.judged()) result_.steps.back().health = judged.health;
    result_.steps.back().searched = judged.searched;
    const ScanAnswer answer{record.stamp_s, judged, tracker_.judged(),
                            estimate.weighted ? filter().last_beams().count : std::size_t{0}};
    if (request_.answered) request_.answered(answer);
    if (request_.stepped) request_.stepped({answer, record, filter()});
    result_.modes = std::move(judged.modes);
    result_.lost_steps += estimate.lost ? 1 : 0;
    ++result_.scans;
    result_.times.add(record.scan.sensor, record.stamp_s);
    earliest_s_ = std::min(earliest_s_, record.stamp_s);
    latest_s_ = std::max(latest_s_, record.stamp_s);
    snapshots_.offer([&] { return snapshot_of(filter(), estimate.pose, last_scan_); });
  }

  const ParticleFilter& filter() const { return tracker_.filter(); }
  std::size_t scans() const { return result_.scans; }
  const ScanTimes& times() const { return result_.times; }

  Localization finish(const LogWarnings& warnings) {
    result_.wall_s = seconds_since(begun_);
    result_.log_s = latest_s_ - earliest_s_;
    if (result_.scans > 0)
      snapshots_.finish([&] { return snapshot_of(filter(), result_.trajectory.back().pose, last_scan_); });
    result_.snapshots = snapshots_.take();
    result_.filter_steps = filter().steps();
    result_.odometry_jumps = filter().odometry_jumps();
    result_.beams = filter().beam_counts();
    result_.lidars = filter().lidars_used();
    result_.warnings = warnings;
    result_.backend = filter().backend_name();
    result_.digest = filter().digest();
    return std::move(result_);
  }

 private:
  Tracker tracker_;
  StartPose start_;
  const LocalizeRequest& request_;
  Pose T_map_odometry_;
  EvenSample<Snapshot> snapshots_{12};
  Scan last_scan_;
  Localization result_;
  double earliest_s_ = 0.0, latest_s_ = 0.0;
  Clock::time_point begun_;
};

std::string modes_text(const std::vector<Mode>& modes) {
  constexpr std::size_t most = 4;
  std::string text;
  for (std::size_t i = 0; i < modes.size() && i < most; ++i) {
    const Pose& p = modes[i].pose;
    text += fmt::format("{}({:.2f} m, {:.2f} m, {:.2f} rad) with {:.0f} %", i == 0 ? "" : ", ", p.x_m, p.y_m,
                        p.theta_rad, 100.0 * modes[i].weight);
  }
  if (modes.size() > most) text += fmt::format(" and {} more", modes.size() - most);
  return text;
}

}  // namespace

Localization localize_log(const GridMap& map, LogReader& log, const LocalizeRequest& request) {
  StrictCheck strict(request.strict, request.log_name);
  ScanStream scans(log, request.config.scan, request.config.lidars, [&](std::size_t line) {
    if (request.read) request.read(log.warnings());
    strict.check_log(log.warnings(), line);
  });
  LogRecord record;
  if (!scans.next(record)) throw no_scan(request.log_name, log.warnings());

  Run run(map, request, record);
  bool more = true;
  while (more && !(request.stop && request.stop())) {
    run.step(record, scans);
    strict.check_step(run.filter(), record.line);
    if (request.progress) request.progress(log.progress(), run.scans());
    more = scans.next(record);
  }
  if (!more) strict.check_whole(run.filter(), run.times());
  Localization result = run.finish(log.warnings());
  result.interrupted = more;
  return result;
}

std::string unused_lidars(const StepConfig& config, const std::vector<LidarUse>& used) {
  std::string without, with;
  const auto append = [](std::string& list, const std::string& name) {
    list += (list.empty() ? "" : ", ") + name;
  };
  for (const LidarUse& lidar : used) append(with, lidar.name);
  for (const LidarConfig& lidar : config.lidars) {
    const auto same = [&](const LidarUse& use) { return use.name == lidar.name; };
    if (std::none_of(used.begin(), used.end(), same)) append(without, "lidars." + lidar.name);
  }
  if (without.empty()) return "";
  return fmt::format("{} in the configuration, but the log has scans of {} only", without, with);
}

ParticleNumbers particle_numbers(const std::vector<StepRecord>& steps) {
  if (steps.empty()) return {0.0, 0.0, 0.0, 0.0};
  ParticleNumbers n{0.0, steps.front().particles, steps.front().particles, 0.0};
  for (const StepRecord& step : steps) {
    n.mean += step.particles;
    n.injected_mean += step.p_injected;
    n.min = std::min(n.min, step.particles);
    n.max = std::max(n.max, step.particles);
  }
  n.mean /= static_cast<double>(steps.size());
  n.injected_mean /= static_cast<double>(steps.size());
  return n;
}

StepTimes step_times(const std::vector<StepRecord>& steps) {
  std::vector<double> ms;
  for (std::size_t i = 1; i < steps.size(); ++i) ms.push_back(steps[i].step_ms);
  const std::vector<double> sorted = ascending(std::move(ms));
  return {median(sorted), nearest_rank(sorted, 99)};
}

std::optional<RunHealth> run_health(const Localization& run) {
  if (run.steps.empty() || !run.steps.front().health) return std::nullopt;
  RunHealth h;
  HealthState before = run.steps.front().health->state;
  for (const StepRecord& step : run.steps) {
    const HealthState state = step.health->state;
    ++h.scans;
    ++(state == HealthState::tracking ? h.tracking : state == HealthState::ambiguous ? h.ambiguous : h.lost);
    h.searches += step.searched ? 1 : 0;
    if (state == HealthState::lost && before != HealthState::lost) h.lost_s.push_back(step.stamp_s);
    before = state;
  }
  h.last = *run.steps.back().health;
  h.modes = run.modes;
  return h;
}

std::string health_text(const RunHealth& h) {
  const auto percent = [&](std::size_t count) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(h.scans);
  };
  return fmt::format("tracking {:.1f} %, ambiguous {:.1f} %, lost {:.1f} % of the scans; searched {} time{}",
                     percent(h.tracking), percent(h.ambiguous), percent(h.lost), h.searches,
                     h.searches == 1 ? "" : "s");
}

std::string doubt_at_end(const Localization& run) {
  const std::optional<RunHealth> h = run_health(run);
  if (!h || h->last.state == HealthState::tracking) return "";
  const std::string probability = fmt::format("with probability {:.2f}", h->last.probability);
  if (h->last.state == HealthState::lost)
    return fmt::format("LOST at the end: the scans do not fit the map there; right {}", probability);
  if (h->modes.size() > 1)
    return fmt::format("AMBIGUOUS at the end: {} places are possible: {}", h->modes.size(),
                       modes_text(h->modes));
  return fmt::format("AMBIGUOUS at the end: other places may explain the scans as well; right {}",
                     probability);
}

}  // namespace parloc::tools
