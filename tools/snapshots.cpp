#include "tools/snapshots.h"

#include <algorithm>
#include <cmath>

namespace parloc::tools {
namespace {

/// End points of the beams that hit something, seen from the estimate; map frame.
std::vector<Snapshot::Point> end_points(const Pose& T_map_base, const Scan& scan, const ScanConfig& config) {
  const Pose T_map_sensor = compose(T_map_base, scan.T_base_sensor);
  const double range_min_m = scan.range_min_m > 0.0 ? scan.range_min_m : config.laser_min_range;
  const double range_max_m = scan.range_max_m > 0.0 ? scan.range_max_m : config.laser_max_range;
  std::vector<Snapshot::Point> points;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = scan.ranges_m[i];
    if (!(range_m > 0.0 && range_m >= range_min_m && range_m < range_max_m)) continue;  // NaN fails too
    const double angle =
        T_map_sensor.theta_rad + scan.angle_min_rad + static_cast<double>(i) * scan.angle_step_rad;
    points.push_back({static_cast<float>(T_map_sensor.x_m + range_m * std::cos(angle)),
                      static_cast<float>(T_map_sensor.y_m + range_m * std::sin(angle))});
  }
  return points;
}

Snapshot snapshot_of(const ParticleFilter& filter, const Pose& estimate, const Scan& scan) {
  return {scan.stamp_s, estimate, filter.particles(Snapshot::max_particles),
          end_points(estimate, scan, filter.config().scan)};
}

}  // namespace

void SnapshotKeeper::offer(const ParticleFilter& filter, const Pose& estimate, const Scan& scan) {
  last_kept_ = offered_++ % stride_ == 0;
  if (!last_kept_) return;
  kept_.push_back(snapshot_of(filter, estimate, scan));
  if (kept_.size() <= most) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < kept_.size(); i += 2) {
    if (kept != i) kept_[kept] = std::move(kept_[i]);
    ++kept;
  }
  kept_.resize(kept);  // `most` is even, so the newest is among them
  stride_ *= 2;
}

void SnapshotKeeper::finish(const ParticleFilter& filter, const Pose& estimate, const Scan& scan) {
  if (!last_kept_) kept_.push_back(snapshot_of(filter, estimate, scan));
}

}  // namespace parloc::tools
