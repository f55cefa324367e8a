// What became of the beams of a scan, or of a whole run.
#pragma once

#include <cstddef>
#include <string>

namespace parloc {

/// How the beams of a scan were sorted out; also summed over a run.
struct BeamCounts {
  std::size_t total = 0;       ///< In the scan.
  std::size_t considered = 0;  ///< After even decimation to max_beams.
  std::size_t used = 0;        ///< Gave evidence.
  std::size_t misses = 0;      ///< Among the considered: at or above the maximum, or +inf.
  std::size_t masked = 0;      ///< Among the considered: they see the robot itself (LidarConfig::mask).
  std::size_t nan = 0;         ///< Rejected: no number.
  std::size_t infinite = 0;    ///< Rejected: -inf.
  std::size_t negative = 0;    ///< Rejected: below 0.
  std::size_t zero = 0;        ///< Rejected: 0, where that is a broken beam (ZeroPolicy).
  std::size_t below_min = 0;   ///< Rejected: below the LiDAR's minimum.

  /// Adds each count.
  BeamCounts& operator+=(const BeamCounts& c) {
    total += c.total, considered += c.considered, used += c.used, misses += c.misses, masked += c.masked;
    nan += c.nan, infinite += c.infinite, negative += c.negative, zero += c.zero, below_min += c.below_min;
    return *this;
  }
  /// For any reason.
  std::size_t rejected() const { return nan + infinite + negative + below_min + zero; }
};

/// What became of one LiDAR's scans over a run.
struct LidarUse {
  std::string name;                ///< As the log calls it.
  int max_beams = 0;               ///< In force for it.
  std::size_t scans = 0;           ///< Whose beams were looked at.
  std::size_t too_few = 0;         ///< Of these, with fewer usable beams than min_beams: not weighed.
  std::size_t smallest = 0;        ///< Fewest beams of a scan.
  std::size_t largest = 0;         ///< And most.
  std::size_t moving = 0;          ///< Scans that took time: every beam from where it was taken.
  std::size_t unknown_motion = 0;  ///< Took time, but no odometry tells the motion: taken as an instant.
  BeamCounts beams;                ///< Of all its scans together.
};

}  // namespace parloc
