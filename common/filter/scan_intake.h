// From a scan to the beams of a step, with a count of what became of them, LiDAR by LiDAR.
#pragma once

#include <string>
#include <vector>

#include "common/filter/step_config.h"
#include "common/model/beams.h"

namespace parloc {

class ScanIntake {
 public:
  /// Its place among those seen so far; new ones are added.
  std::size_t lidar_of(const Scan& scan);
  /// Fills `beams` with those that count, seen from the base at the scan's stamp; whether there are enough.
  /// `config` has min_beams. Allocates only for the largest scan so far. Throws Error{input} for a scan whose
  /// arrays do not fit together.
  bool take(const Scan& scan, std::size_t lidar, const ScanConfig& config,
            const std::vector<LidarConfig>& lidars, const SensorConfig& sensor, const OdometryTrack& track,
            double resolution_m, BeamTable& beams);
  void clear();
  const std::vector<LidarUse>& used() const { return used_; }
  /// Goes on counting from there.
  void set_used(std::vector<LidarUse> used);
  BeamCounts total() const;

 private:
  std::vector<LidarUse> used_;
  std::vector<BeamDirections> directions_;  // of each
};

}  // namespace parloc
