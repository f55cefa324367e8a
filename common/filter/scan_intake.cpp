#include "common/filter/scan_intake.h"

#include <algorithm>
#include <utility>

namespace parloc {

std::size_t ScanIntake::lidar_of(const Scan& scan) {
  for (std::size_t k = 0; k < used_.size(); ++k)
    if (used_[k].name == scan.sensor) return k;
  used_.emplace_back().name = scan.sensor;
  directions_.emplace_back();
  return used_.size() - 1;
}

void ScanIntake::clear() {
  used_.clear();
  directions_.clear();
}

void ScanIntake::set_used(std::vector<LidarUse> used) {
  used_ = std::move(used);
  directions_.assign(used_.size(), {});
}

bool ScanIntake::take(const Scan& scan, std::size_t lidar, const ScanConfig& config,
                      const std::vector<LidarConfig>& lidars, const SensorConfig& sensor,
                      const OdometryTrack& track, double resolution_m, BeamTable& beams) {
  LidarUse& use = used_[lidar];
  const LidarSetup setup = lidar_setup(scan, config, find_lidar(lidars, scan.sensor));
  const bool moving = takes_time(scan, setup);
  const bool deskew = moving && track.knows_motion();
  select_beams(scan, setup, deskew ? &track : nullptr, sensor, resolution_m, beams, use.beams,
               &directions_[lidar]);
  const bool enough = beams.count >= static_cast<std::size_t>(config.min_beams);

  const std::size_t size = scan.ranges_m.size();
  use.max_beams = setup.max_beams;
  use.smallest = use.scans == 0 ? size : std::min(use.smallest, size);
  use.largest = std::max(use.largest, size);
  ++use.scans;
  use.moving += moving ? 1 : 0;
  use.unknown_motion += moving && !deskew ? 1 : 0;
  use.too_few += enough ? 0 : 1;
  use.beams.used += enough ? beams.count : 0;
  return enough;
}

BeamCounts ScanIntake::total() const {
  BeamCounts sum;
  for (const LidarUse& lidar : used_) {
    const BeamCounts& c = lidar.beams;
    sum.total += c.total;
    sum.considered += c.considered;
    sum.used += c.used;
    sum.misses += c.misses;
    sum.nan += c.nan;
    sum.infinite += c.infinite;
    sum.negative += c.negative;
    sum.zero += c.zero;
    sum.below_min += c.below_min;
  }
  return sum;
}

}  // namespace parloc
