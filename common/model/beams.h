// The beams of one scan as the sensor models need them: sorted out once on the host, then read by every
// particle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/portable64.h"
#include "common/model/beam_counts.h"
#include "common/model/beam_table.h"
#include "common/model/lidar.h"
#include "common/model/odometry_track.h"
#include "common/model/scan.h"
#include "common/model/sensor_config.h"

namespace parloc {

/// Where the beams of a LiDAR look, remembered from scan to scan as long as nothing about it changes: sines
/// cost more than all else that select_beams does.
class BeamDirections {
 public:
  /// To be called once per scan, before any other.
  void expect(const Scan& scan, const LidarSetup& setup);
  /// Base frame; of a LiDAR that stands still, or is taken to.
  const SinCos64& of(const Scan& scan, const LidarSetup& setup, std::size_t i);

 private:
  Pose T_base_sensor_;
  bool upside_down_ = false;
  bool even_ = true;  ///< Bearings of their own are not compared: they are remembered for one scan only.
  double angle_min_rad_ = 0.0, angle_step_rad_ = 0.0;
  std::vector<SinCos64> direction_;  ///< By beam; (2, 2): not asked for yet.
};

/// Takes B = max_beams of a scan's M beams evenly in angle, then classifies them (SPEC 0.3); adds to
/// `counts`. The field of view is cut into B equal parts, and each gives the last beam at or before its
/// beginning: with even beams those of the indices floor(k M / B). Where uneven beams leave a part without
/// one of its own, none is taken twice: fewer than B are `considered`. With a track, every beam starts and
/// points as it did at its own time, seen from the base at the scan's stamp; without, the scan was taken in
/// an instant. Fills `table`, whose vectors keep their capacity: no allocation once they have grown.
/// Deterministic on every machine (no libm but sqrt, floor, rint, fma). `directions`, if any: of this LiDAR.
void select_beams(const Scan& scan, const LidarSetup& setup, const OdometryTrack* track,
                  const SensorConfig& sensor, double resolution_m, BeamTable& table, BeamCounts& counts,
                  BeamDirections* directions = nullptr);
/// The same for a scan of which no more is known than it says, taken in an instant.
void select_beams(const Scan& scan, const ScanConfig& scan_config, const SensorConfig& sensor,
                  double resolution_m, BeamTable& table, BeamCounts& counts);

/// Where all beams that hit something ended, decimation apart, by the same rules; for pictures.
std::vector<EndPoint> end_points(const Scan& scan, const LidarSetup& setup, const OdometryTrack* track);

/// Fills in what the shape says of the origins.
void measure_origins(BeamTable& table);

/// The same beams in another order, hits still before misses: any first few look all around. `out` keeps its
/// capacity.
void scatter_beams(const BeamTable& table, BeamTable& out);

}  // namespace parloc
