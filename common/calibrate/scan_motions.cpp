#include "common/calibrate/scan_motions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace parloc {
namespace {

/// A stamp so much before the newest is another clock, or another drive.
constexpr double kOtherClock_s = 2.0, kBetweenDrives_s = 100.0;

/// So many links' way by the odometry, and a link is due whatever the speed was.
constexpr double kFar = 1.5;
/// Links per time since the last one of a LiDAR that stands: the next is due when the odometry says so.
constexpr double kStands = 1e-3;

/// A match as good as this needs no second start.
constexpr double kGoodShare = 0.8;

bool better(const LineMatch& a, const LineMatch& b) {
  return a.fits() != b.fits() ? a.fits() : a.share > b.share;
}

/// Where the LiDAR sits is not known yet, nor on which side it turns: the odometry says how far the robot has
/// moved, and starts lie on that circle.
LineMatch match_from_circle(const LineScan& reference, const LineScan& moved, const Pose& odometry) {
  LineMatch best = match_lines(reference, moved, {});
  const double way_m = distance_m({}, odometry);
  constexpr std::array<std::array<double, 2>, 9> kDirections{
      {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {.7, .7}, {.7, -.7}, {-.7, .7}, {-.7, -.7}}};
  for (const auto& direction : kDirections) {
    for (const double side : {1.0, -1.0}) {
      if (best.share >= kGoodShare) return best;
      const Pose start{way_m * direction[0], way_m * direction[1], side * odometry.theta_rad};
      const LineMatch match = match_lines(reference, moved, start);
      if (better(match, best)) best = match;
    }
    if (way_m < ScanMotions::kChainStep_m) break;
  }
  return best;
}

Mount stated_mount(const Scan& scan, const ScanConfig& config, const std::vector<LidarConfig>& settings) {
  const LidarSetup setup = lidar_setup(scan, config, find_lidar(settings, scan.sensor));
  return {setup.T_base_sensor, setup.upside_down};
}

}  // namespace

Pose mirrored(const Pose& step) {
  return {step.x_m, -step.y_m, -step.theta_rad};
}

std::size_t LidarMotions::usable() const {
  return static_cast<std::size_t>(
      std::count_if(motions.begin(), motions.end(), [](const ScanMotion& m) { return m.usable; }));
}

double ScanMotions::time_of(double stamp_s) {
  if (!readings_.empty() && stamp_s + shift_s_ < newest_s_ - kOtherClock_s)
    shift_s_ = newest_s_ + kBetweenDrives_s - stamp_s;
  const double time_s = stamp_s + shift_s_;
  newest_s_ = readings_.empty() ? time_s : std::max(newest_s_, time_s);
  return time_s;
}

void ScanMotions::add(const LogRecord& record) {
  if (!is_finite(record.odometry)) return;
  const double time_s = time_of(record.stamp_s);
  readings_.push_back({time_s, record.odometry});
  if (record.kind == RecordKind::scan) add_scan(record, time_s);
}

Trajectory ScanMotions::odometry() const {
  Trajectory sorted = readings_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp_s < b.stamp_s; });
  return sorted;
}

std::size_t ScanMotions::lidar_of(const Scan& scan) {
  for (std::size_t k = 0; k < lidars_.size(); ++k)
    if (lidars_[k].name == scan.sensor) return k;
  lidars_.push_back({.name = scan.sensor, .stated = stated_mount(scan, config_, settings_)});
  chains_.emplace_back();
  return lidars_.size() - 1;
}

void ScanMotions::start_key(LidarMotions& lidar, Chain& chain, const LogRecord& record, double time_s,
                            LineScan lines) {
  lidar.keys.push_back({time_s, record.scan});
  chain.linked_odometry = record.odometry;
  chain.last_s = chain.linked_s = time_s;
  chain.since_key = {};
  if (!chain.unbroken) chain.due_s = time_s;
  chain.unbroken = true;
  chain.key = lines;
  chain.linked = std::move(lines);
}

void ScanMotions::add_scan(const LogRecord& record, double time_s) {
  ++scans_;
  const std::size_t index = lidar_of(record.scan);
  LidarMotions& lidar = lidars_[index];
  Chain& chain = chains_[index];
  ++lidar.scans;
  if (lidar.keys.size() >= kMostKeys) return;
  const auto lines = [&] {
    return line_scan(record.scan,
                     lidar_setup(record.scan, config_, find_lidar(settings_, record.scan.sensor)));
  };
  if (lidar.keys.empty()) return start_key(lidar, chain, record, time_s, lines());
  const bool gap = time_s - chain.last_s > kLongestGap_s;
  chain.unbroken = chain.unbroken && !gap;
  chain.last_s = time_s;
  const Pose step = relative(record.odometry, chain.linked_odometry);
  const bool far = distance_m({}, step) >= kFar * kChainStep_m || turn_rad({}, step) >= kFar * kChainTurn_rad;
  if (chain.unbroken && time_s < chain.due_s && !far) return;

  LineScan now = lines();
  if (chain.unbroken) link(chain, now, step, time_s);
  chain.linked_odometry = record.odometry;
  const bool is_key = distance_m({}, chain.since_key) >= kKeyStep_m ||
                      turn_rad({}, chain.since_key) >= kKeyTurn_rad || !chain.unbroken;
  if (is_key) {
    ScanMotion motion{.from = lidar.keys.size() - 1, .gap = gap};
    if (chain.unbroken) motion.match = match_lines(chain.key, now, chain.since_key);
    motion.usable = chain.unbroken && motion.match.fits();
    lidar.motions.push_back(motion);
    return start_key(lidar, chain, record, time_s, std::move(now));
  }
  chain.linked = std::move(now);
}

/// The next link is due when, by the speed of this one, the LiDAR has moved as far again.
void ScanMotions::link(Chain& chain, const LineScan& now, const Pose& odometry, double time_s) {
  const LineMatch match = match_from_circle(chain.linked, now, odometry);
  chain.unbroken = match.fits();
  chain.since_key = compose(chain.since_key, match.step);
  const double links =
      std::max(distance_m({}, match.step) / kChainStep_m, std::fabs(match.step.theta_rad) / kChainTurn_rad);
  chain.due_s = time_s + (time_s - chain.linked_s) / std::max(links, kStands);
  chain.linked_s = time_s;
}

bool ScanMotions::takes_time(const LidarMotions& lidar) const {
  return std::any_of(lidar.keys.begin(), lidar.keys.end(), [&](const KeyScan& key) {
    return parloc::takes_time(key.scan,
                              lidar_setup(key.scan, config_, find_lidar(settings_, key.scan.sensor)));
  });
}

bool ScanMotions::match_again(LidarMotions& lidar, const OdometryPath& path, const MotionGuess& guess,
                              const std::function<bool(double fraction)>& keep_going) const {
  const Pose &X = guess.mount.T_base_sensor, back = inverse(X);
  const auto sensor_step = [&](double from_s, double to_s) {
    const Pose base = relative(path.at(to_s + guess.delay_s), path.at(from_s + guess.delay_s));
    const Pose step = compose(compose(back, base), X);
    return guess.mount.upside_down ? mirrored(step) : step;
  };
  const auto lines_of = [&](const KeyScan& key) {
    const LidarSetup setup = lidar_setup(key.scan, config_, find_lidar(settings_, key.scan.sensor));
    if (!parloc::takes_time(key.scan, setup)) return line_scan(key.scan, setup);
    return line_scan(key.scan, setup,
                     [&](double time_s) { return sensor_step(key.time_s, key.time_s + time_s); });
  };
  const bool moves = takes_time(lidar);
  LineScan before;
  for (std::size_t k = 0; k < lidar.keys.size(); ++k) {
    LineScan now = lines_of(lidar.keys[k]);
    if (k > 0) {
      ScanMotion& motion = lidar.motions[k - 1];
      const double from_s = lidar.keys[k - 1].time_s, to_s = lidar.keys[k].time_s;
      const LineMatch match = match_lines(before, now, sensor_step(from_s, to_s));
      if (!motion.usable || moves || better(match, motion.match)) motion.match = match;
      motion.usable = motion.match.fits() && !motion.gap;
    }
    before = std::move(now);
    if (keep_going && !keep_going(static_cast<double>(k + 1) / static_cast<double>(lidar.keys.size())))
      return false;
  }
  return true;
}

}  // namespace parloc
