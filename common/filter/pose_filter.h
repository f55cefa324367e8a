// Any filter that tracks a pose from a known start, behind one interface: for loops that compare them.
#pragma once

#include <cstdint>
#include <string>

#include "common/filter/particle_filter.h"

namespace parloc {

/// Not thread-safe. Deterministic, as ParticleFilter.
class PoseFilter {
 public:
  virtual ~PoseFilter() = default;
  /// Gaussian start. Throws Error{input} if the pose is not finite or lies outside the map.
  virtual void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m,
                        double sigma_theta_rad) = 0;
  /// From the next start on.
  virtual void set_seed(std::uint64_t seed) = 0;
  /// Between steps, in any order: how the robot moves while a scan is taken.
  virtual void add_odometry(double stamp_s, const Pose& odometry) = 0;
  /// Moves by the odometry since the last call (first call: not at all) and takes the scan in.
  /// Estimate::weighted tells whether that changed anything.
  virtual Estimate step(const Pose& odometry, const Scan& scan) = 0;
  /// Why the last step's scan changed nothing; empty if it did.
  virtual std::string why_skipped() const = 0;
  virtual BeamCounts beam_counts() const = 0;  ///< Summed since the start.
  virtual std::size_t steps() const = 0;
  virtual std::string backend_name() const = 0;
  /// SHA-256 over what the filter holds and over every step's estimate, hex.
  virtual std::string digest() const = 0;
};

}  // namespace parloc
