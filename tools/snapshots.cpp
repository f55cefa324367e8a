#include "tools/snapshots.h"

#include <algorithm>
#include <cmath>

namespace parloc::tools {
namespace {

/// End points of the beams that hit something, seen from the estimate; map frame.
std::vector<Snapshot::Point> end_points(const ParticleFilter& filter, const Pose& T_map_base,
                                        const Scan& scan) {
  std::vector<Snapshot::Point> points;
  const double c = std::cos(T_map_base.theta_rad), s = std::sin(T_map_base.theta_rad);
  for (const EndPoint& p : filter.end_points(scan)) {
    points.push_back({static_cast<float>(T_map_base.x_m + c * p.x_m - s * p.y_m),
                      static_cast<float>(T_map_base.y_m + s * p.x_m + c * p.y_m)});
  }
  return points;
}

Snapshot snapshot_of(const ParticleFilter& filter, const Pose& estimate, const Scan& scan) {
  return {scan.stamp_s, estimate, filter.particles(Snapshot::max_particles),
          end_points(filter, estimate, scan)};
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
