#include "tools/log/log_survey.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "common/calibrate/mount_check.h"
#include "common/io/mount_watch.h"

namespace parloc::tools {

namespace {

constexpr double kWindow_s = 0.5;
constexpr double kStanding_mps = 0.01, kStanding_rad_s = 0.01;

class OdometryReader {
 public:
  explicit OdometryReader(OdometrySurvey& survey) : survey_(survey) {}

  void add(double stamp_s, const Pose& odometry) {
    survey_.stamps.add(stamp_s);
    if (!window_.empty() && stamp_s <= window_.back().stamp_s) {
      if (stamp_s < window_.back().stamp_s) window_.clear();  // the clock was set back
      if (!window_.empty()) return;
    }
    if (!window_.empty()) step(stamp_s, odometry);
    window_.push_back({stamp_s, odometry});
  }

  ~OdometryReader() {
    if (still_steps_ == 0) return;
    survey_.standing_noise_m = std::sqrt(still_m2_ / static_cast<double>(still_steps_));
    survey_.standing_noise_rad = std::sqrt(still_rad2_ / static_cast<double>(still_steps_));
  }

 private:
  struct Reading {
    double stamp_s;
    Pose odometry;
  };

  void step(double stamp_s, const Pose& odometry) {
    const Reading& before = window_.back();
    const double moved_m = distance_m(before.odometry, odometry);
    const double turned = std::fabs(turn_rad(before.odometry, odometry));
    survey_.length_m += moved_m;
    survey_.turned_rad += turned;
    // The last reading that is half a second ago.
    while (window_.size() > 1 && window_[1].stamp_s <= stamp_s - kWindow_s) window_.pop_front();
    const Reading& then = window_.front();
    const double time_s = stamp_s - then.stamp_s;
    if (time_s < kWindow_s) return;
    const double speed_mps = distance_m(then.odometry, odometry) / time_s;
    const double rate_rad_s = std::fabs(turn_rad(then.odometry, odometry)) / time_s;
    survey_.max_speed_mps = std::max(survey_.max_speed_mps, speed_mps);
    survey_.max_turn_rate_rad_s = std::max(survey_.max_turn_rate_rad_s, rate_rad_s);
    if (speed_mps >= kStanding_mps || rate_rad_s >= kStanding_rad_s) return;
    survey_.standing_s += stamp_s - before.stamp_s;
    still_m2_ += moved_m * moved_m;
    still_rad2_ += turned * turned;
    ++still_steps_;
  }

  OdometrySurvey& survey_;
  std::deque<Reading> window_;
  double still_m2_ = 0.0, still_rad2_ = 0.0;
  std::size_t still_steps_ = 0;
};

void look_at_first(const Scan& scan, ScanSurvey& s) {
  const auto last = static_cast<double>(scan.ranges_m.size()) - 1.0;
  s.uneven = !scan.bearings_rad.empty();
  s.first_bearing_rad = s.uneven ? scan.bearings_rad.front() : scan.angle_min_rad;
  s.last_bearing_rad = s.uneven ? scan.bearings_rad.back() : scan.angle_min_rad + last * scan.angle_step_rad;
  s.angle_step_rad = scan.angle_step_rad;
  s.range_min_m = scan.range_min_m;
  s.range_max_m = scan.range_max_m;
  s.scan_time_s = scan.scan_time_s;
  s.T_base_sensor = scan.T_base_sensor;
  s.upside_down = scan.upside_down;
}

void count_ranges(const Scan& scan, ScanSurvey& s) {
  const double most_m = scan.range_max_m > 0.0 ? scan.range_max_m : INFINITY;
  for (const float range : scan.ranges_m) {
    if (std::isnan(range)) {
      ++s.not_a_number;
    } else if (std::isinf(range)) {
      ++s.infinite;
    } else if (range == 0.0f) {
      ++s.zero;
    } else if (range < 0.0f) {
      ++s.negative;
    } else if (static_cast<double>(range) >= most_m) {
      ++s.far;
    } else {
      const double range_m = range;
      s.nearest_m = s.good == 0 ? range_m : std::min(s.nearest_m, range_m);
      s.farthest_m = std::max(s.farthest_m, range_m);
      ++s.good;
    }
  }
}

}  // namespace

LogSurvey survey_log(LogReader& log, const std::vector<LidarConfig>& lidars,
                     const std::function<void(double)>& progress, const std::function<bool()>& stop) {
  LogSurvey survey;
  MountWatch mounts;
  MountCheck check(lidars);
  {
    OdometryReader odometry(survey.odometry);
    for (LogRecord record; !(survey.interrupted = stop()) && log.next(record);) {
      odometry.add(record.stamp_s, record.odometry);
      if (!check.enough()) check.add(record);
      if (record.kind == RecordKind::odometry) {
        ++survey.odometry.alone;
        continue;
      }
      ScanSurvey& s = survey.lidars[record.scan.sensor];
      if (s.stamps.count() == 0) look_at_first(record.scan, s);
      s.stamps.add(record.stamp_s);
      ++s.scans_of_beams[record.scan.ranges_m.size()];
      count_ranges(record.scan, s);
      s.mount_moves = s.mount_moves || mounts.look(record).has_value();
      progress(log.progress());
    }
  }
  survey.warnings = log.warnings();
  if (!survey.interrupted) survey.mounts = check.verdict();
  return survey;
}

}  // namespace parloc::tools
