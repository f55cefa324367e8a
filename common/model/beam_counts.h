// What became of the beams of a scan, or of a whole run.
#pragma once

#include <cstddef>

namespace parloc {

/// How the beams of a scan were sorted out; also summed over a run.
struct BeamCounts {
  std::size_t total = 0;       ///< In the scan.
  std::size_t considered = 0;  ///< After even decimation to max_beams.
  std::size_t used = 0;        ///< Gave evidence.
  std::size_t misses = 0;      ///< Among the considered: at or above the maximum, or +inf.
  std::size_t nan = 0, infinite = 0, negative = 0, zero = 0, below_min = 0;  ///< Rejected, by reason.
};

}  // namespace parloc
