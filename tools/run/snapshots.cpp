#include "tools/run/snapshots.h"

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
  kept_.offer([&] { return snapshot_of(filter, estimate, scan); });
}

void SnapshotKeeper::finish(const ParticleFilter& filter, const Pose& estimate, const Scan& scan) {
  kept_.finish([&] { return snapshot_of(filter, estimate, scan); });
}

}  // namespace parloc::tools
