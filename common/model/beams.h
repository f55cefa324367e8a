// The beams of one scan as the sensor models need them: sorted out once on the host, then read by every
// particle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/filter/config.h"
#include "common/io/log.h"
#include "common/model/beam_counts.h"
#include "common/model/scan_shape.h"

namespace parloc {

constexpr std::size_t kMaxBeams = 4096;

/// Structure of arrays, one entry per usable beam: first the `hits`, then the misses (nothing within range).
/// Everything is in the base frame at the scan's time; end points in cells, for hits only.
struct BeamTable : ScanShape {
  /// Where each beam starts [m]: they differ with several LiDARs, or one that moves during its scan.
  std::vector<float> origin_x, origin_y;
  std::vector<float> direction_x, direction_y;  ///< Unit vectors.
  std::vector<float> range_m;                   ///< Measured; range_max_m for a miss.
  std::vector<float> short_density;  ///< z_short lambda exp(-lambda range): the beam model's constant.
  std::vector<float> end_x, end_y;   ///< [cells]
};

/// Decimates to max_beams at evenly spaced indices floor(k M / B), then classifies (SPEC 0.3); adds to
/// `counts`. Fills `table`, whose vectors keep their capacity: no allocation once they have grown.
/// Deterministic on every machine (no libm but sqrt, floor, rint, fma).
void select_beams(const Scan& scan, const ScanConfig& scan_config, const SensorConfig& sensor,
                  double resolution_m, BeamTable& table, BeamCounts& counts);

/// Fills in what the shape says of the origins.
void measure_origins(BeamTable& table);

/// The same beams in another order, hits still before misses: any first few look all around. `out` keeps its
/// capacity.
void scatter_beams(const BeamTable& table, BeamTable& out);

}  // namespace parloc
