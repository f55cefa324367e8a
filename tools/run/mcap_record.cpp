#include "tools/run/mcap_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/error.h"
#include "common/inputs/map_message.h"
#include "common/model/lidar.h"

namespace parloc::tools {
namespace {

constexpr const char* kMap = "map";
constexpr double kLongestChunk_s = 1.0;       // of wall time: what kill -9 may cost
constexpr double kCloudEvery_s = 0.5;         // of the log
constexpr std::size_t kMostParticles = 500;   // a cloud looks like itself with fewer than it has
constexpr double kPathEvery_s = 5.0;          // of the log, ...
constexpr double kPathShare = 0.02;           // ... and of the time so far: the file grows with the log
constexpr std::size_t kMostPathPoses = 1000;  // even
constexpr std::size_t kMostCells = std::size_t{32} << 20;  // 32 MiB: readers have limits

/// Beams with angles of their own, on an even grid as fine as the closest two of them: what falls together is
/// the nearest, what is between is not measured.
void make_even(Scan& scan) {
  const std::vector<double> bearings_rad = std::exchange(scan.bearings_rad, {});
  const std::size_t n = bearings_rad.size();
  double least_rad = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < n; ++k) {
    const double gap_rad = std::fabs(bearings_rad[k] - bearings_rad[k - 1]);
    if (gap_rad > 0.0) least_rad = std::min(least_rad, gap_rad);
  }
  if (n < 2 || !std::isfinite(least_rad)) return;
  constexpr double most_cells = 4096.0;
  const double view_rad = bearings_rad.back() - bearings_rad.front();
  const double gaps = std::min(most_cells, std::ceil(std::fabs(view_rad) / least_rad - 1e-6));
  scan.angle_min_rad = bearings_rad.front();
  scan.angle_step_rad = view_rad / gaps;
  std::vector<float> even(static_cast<std::size_t>(gaps) + 1, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t k = 0; k < n; ++k) {
    const auto at =
        static_cast<std::size_t>(std::lround((bearings_rad[k] - bearings_rad.front()) / scan.angle_step_rad));
    if (!(even[at] <= scan.ranges_m[k])) even[at] = scan.ranges_m[k];
  }
  scan.ranges_m = std::move(even);
}

/// As the filter takes it: what the settings say of its LiDAR is in it.
Scan shown_scan(const Scan& recorded, const Config& config) {
  const LidarSetup setup = lidar_setup(recorded, config.scan, find_lidar(config.lidars, recorded.sensor));
  Scan scan = recorded;
  scan.T_base_sensor = setup.T_base_sensor;
  scan.upside_down = setup.upside_down;
  scan.angle_min_rad = setup.angle_min_rad;
  scan.angle_step_rad = setup.angle_step_rad;
  scan.range_min_m = setup.range_min_m;
  scan.range_max_m = setup.range_max_m;
  scan.scan_time_s = setup.scan_time_s;
  scan.beam_times_s.clear();
  if (setup.own_bearings)
    make_even(scan);
  else
    scan.bearings_rad.clear();
  return scan;
}

Trajectory by_time(Trajectory poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp_s < b.stamp_s; });
  return poses;
}

DiagnosticMessage::Level level_of(const ScanAnswer& answer) {
  using Level = DiagnosticMessage::Level;
  if (!answer.judged) return answer.estimate.filter.lost ? Level::error : Level::ok;
  const HealthState state = answer.estimate.health.state;
  return state == HealthState::tracking ? Level::ok : state == HealthState::lost ? Level::error : Level::warn;
}

}  // namespace

McapRecord::McapRecord(const std::string& path, const GridMap& map, const Trajectory& truth,
                       const Config& config)
    : file_(path),
      map_(map),
      config_(config),
      truth_(by_time(truth)),
      log_([&](std::string_view bytes) { file_.append(bytes); }, kLongestChunk_s),
      several_lidars_(config.lidars.size() > 1 || config.log.scan_topic.find(',') != std::string::npos),
      cloud_s_(std::numeric_limits<double>::quiet_NaN()),
      path_s_(std::numeric_limits<double>::quiet_NaN()),
      path_(kMostPathPoses) {}

McapRecord::~McapRecord() {
  try {
    finish();
  } catch (const Error&) {  // there is a worse one
  }
}

void McapRecord::finish() {
  if (messages() > 0 && !std::exchange(finished_, true)) log_.finish();
}

void McapRecord::begin(double stamp_s) {
  first_s_ = stamp_s;
  log_.write("/map", "nav_msgs/msg/OccupancyGrid", stamp_s,
             write_occupancy_grid(message_of_map(map_, {stamp_s, kMap}, kMostCells)), true);
  if (truth_.empty()) return;
  EvenSample<StampedPose> thinned(2 * kMostPathPoses);
  for (const StampedPose& row : truth_) thinned.offer([&] { return row; });
  thinned.finish([&] { return truth_.back(); });
  log_.write("/truth_path", "nav_msgs/msg/Path", stamp_s, parloc::write_path({stamp_s, kMap}, thinned.kept()),
             true);
}

void McapRecord::add(const StepView& step) {
  const double stamp_s = step.record.stamp_s;
  if (messages() == 0) begin(stamp_s);
  const MessageHeader header{stamp_s, kMap};
  const Estimate& estimate = step.answer.estimate.filter;
  write_transforms(step);
  write_scan(step.record.scan);
  log_.write("/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped", stamp_s,
             write_pose_with_covariance(header, estimate.pose, estimate.covariance.v));
  write_health(step.answer);
  write_particles(step);
  write_path(step);
  write_truth(stamp_s);
}

void McapRecord::write_transforms(const StepView& step) {
  const double stamp_s = step.record.stamp_s;
  const Pose& odometry = step.record.odometry;
  const Pose T_map_odometry = compose(step.answer.estimate.filter.pose, inverse(odometry));
  log_.write_transforms(stamp_s, {{{stamp_s, kMap}, McapLog::kOdometry, spatial(T_map_odometry)},
                                  {{stamp_s, McapLog::kOdometry}, McapLog::kBase, spatial(odometry)}});
}

void McapRecord::write_scan(const Scan& scan) {
  if (scan.ranges_m.empty()) return;
  if (first_lidar_.empty()) first_lidar_ = scan.sensor;
  log_.write_scan(topic_of(scan.sensor), shown_scan(scan, config_));
}

/// How many LiDARs a log has is known at its end: where nothing says that there are several, the first one is
/// on /scan.
std::string McapRecord::topic_of(const std::string& sensor) const {
  if (sensor.empty() || (!several_lidars_ && sensor == first_lidar_)) return "/scan";
  return "/" + sensor + (sensor.ends_with("scan") ? "" : "/scan");
}

bool McapRecord::due(double now_s, double every_s, double& last_s) {
  if (now_s >= last_s && now_s < last_s + every_s) return false;
  last_s = now_s;
  return true;
}

void McapRecord::write_particles(const StepView& step) {
  const double stamp_s = step.record.stamp_s;
  if (!due(stamp_s, kCloudEvery_s, cloud_s_)) return;
  std::vector<WeightedPose> particles;
  for (const Particle& p : step.filter.particles(kMostParticles))
    particles.push_back({{p.x_m, p.y_m, p.theta_rad}, p.weight});
  log_.write("/particle_cloud", "nav2_msgs/msg/ParticleCloud", stamp_s,
             parloc::write_particles({stamp_s, kMap}, particles));
}

void McapRecord::write_path(const StepView& step) {
  const StampedPose now{step.record.stamp_s, step.answer.estimate.filter.pose};
  path_.offer([&] { return now; });
  if (!due(now.stamp_s, std::max(kPathEvery_s, kPathShare * (now.stamp_s - first_s_)), path_s_)) return;
  Trajectory path = path_.kept();
  if (path.back().stamp_s != now.stamp_s) path.push_back(now);
  log_.write("/path", "nav_msgs/msg/Path", now.stamp_s, parloc::write_path({now.stamp_s, kMap}, path));
}

/// The last row that is not later than the scan.
void McapRecord::write_truth(double stamp_s) {
  const auto later = [](double stamp, const StampedPose& row) { return stamp < row.stamp_s; };
  const auto end = std::upper_bound(truth_.begin(), truth_.end(), stamp_s, later);
  const auto past = static_cast<std::size_t>(end - truth_.begin());
  if (past == truth_written_ || past == 0) return;
  truth_written_ = past;
  const StampedPose& row = truth_[past - 1];
  log_.write("/truth", "geometry_msgs/msg/PoseStamped", stamp_s, write_pose({row.stamp_s, kMap}, row.pose));
}

void McapRecord::write_health(const ScanAnswer& answer) {
  const LocalizerEstimate& said = answer.estimate;
  DiagnosticMessage message;
  message.header = {answer.stamp_s, kMap};
  message.level = level_of(answer);
  message.name = "parloc: localization";
  message.message = answer.judged ? name_of(said.health.state) : "not judged";
  if (answer.judged) {
    message.values = {{"state", name_of(said.health.state)},
                      {"probability", fmt::format("{:.4f}", said.health.probability)},
                      {"evidence", fmt::format("{:.4f}", said.health.evidence)}};
  }
  message.values.emplace_back("n_eff", fmt::format("{:.1f}", said.filter.n_eff));
  message.values.emplace_back("particles", fmt::format("{}", said.filter.particles));
  message.values.emplace_back("hypotheses", fmt::format("{}", said.modes.size()));
  message.values.emplace_back("beams_used", fmt::format("{}", answer.beams_used));
  message.values.emplace_back("searched", said.searched ? "true" : "false");
  log_.write("/health", "diagnostic_msgs/msg/DiagnosticArray", answer.stamp_s, write_diagnostics(message));
}

}  // namespace parloc::tools
