// What filters say of a robot's pose, and what all of them can that track it from a known start: for loops
// that compare them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "common/model/beam_counts.h"
#include "common/model/continuous_odometry.h"
#include "common/model/scan.h"

namespace parloc {

/// 3x3 covariance of (x, y, theta), row-major, symmetric [m^2, m rad, rad^2].
struct Covariance {
  double v[9] = {};
};

/// A weighted mean with circular heading, and its covariance, in the map frame.
struct PoseEstimate {
  Pose mean;
  Covariance covariance;
  double weight = 0.0;             ///< Share of the total weight, 0 to 1.
  double heading_resultant = 0.0;  ///< R of the circular mean: 1 is certain, 0 undefined.
};

/// What one filter step says. The only thing that comes up from the device in a step.
struct Estimate {
  Pose pose;              ///< Of the mode chosen in the configuration.
  Covariance covariance;  ///< Of the same.
  PoseEstimate mean;      ///< All particles.
  PoseEstimate cluster;   ///< The heaviest connected cluster of 0.5 m x 0.5 m x 10 degree bins.
  double n_eff = 0.0;
  std::size_t particles = 0;     ///< That were weighed: where their number adapts, it differs by step.
  double p_injected = 0.0;       ///< Share of the next particles that is drawn from free space.
  double beam_likelihood = 0.0;  ///< Of the last scan used: geometric mean over its beams; 0: none yet.
  bool weighted = false;         ///< A scan was used (else prediction only).
  bool resampled = false;
  bool lost = false;               ///< Every particle had weight zero: weights were made uniform.
  bool ambiguous_heading = false;  ///< The mean's heading is undefined; the cluster's was taken.
};

/// A particle as a user sees it: map frame, weight share.
struct Particle {
  float x_m, y_m, theta_rad, weight;
};

/// Not thread-safe; one object per filter. Deterministic: the same configuration, map and calls give the same
/// bits on every backend, thread count and instruction set (docs/determinism.md).
class PoseFilter {
 public:
  virtual ~PoseFilter();
  PoseFilter(PoseFilter&&) noexcept;
  PoseFilter& operator=(PoseFilter&&) noexcept;

  /// Gaussian start. Throws Error{input} if the pose is not finite or lies outside the map.
  virtual void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m,
                        double sigma_theta_rad) = 0;
  /// From the next start on.
  void set_seed(std::uint64_t seed);
  /// An odometry reading between steps, in any order: how the robot moves while a scan is taken. Matters only
  /// for scans that take time, and those also know the odometry of the steps; readings up to the last beam's
  /// time, given before the step, spare it a guess.
  void add_odometry(double stamp_s, const Pose& odometry);
  /// Moves by the odometry since the last call (first call: not at all) and takes the scan in. `odometry` is
  /// that at the scan's stamp. Scans of several LiDARs (Scan::sensor) are steps of their own, in any order.
  /// Non-finite odometry is skipped and counted. Estimate::weighted tells whether the scan changed anything.
  /// Throws Error{input} for a scan whose arrays do not fit together.
  virtual Estimate step(const Pose& odometry, const Scan& scan) = 0;
  /// How the next step will take its odometry: at the time of its scan, and without jumps. To be called at
  /// most once before that step, with the same; nothing if it is not finite.
  std::optional<OdometryReading> prepare_odometry(double stamp_s, const Pose& odometry);
  /// Why the last step's scan changed nothing; empty if it did.
  const std::string& why_skipped() const;

  /// The particles of the last step (downloads them), if there are any; at most `most`, evenly by slot.
  /// Weights are shares of all.
  std::vector<Particle> particles(std::size_t most = SIZE_MAX) const;
  BeamCounts beam_counts() const;                    ///< Summed since the start, over all LiDARs.
  const std::vector<LidarUse>& lidars_used() const;  ///< By LiDAR, in the order in which they came.
  std::size_t odometry_jumps() const;                ///< Steps that no robot makes (ContinuousOdometry).
  std::size_t odometry_invalid() const;              ///< Steps skipped because the odometry was not finite.
  std::size_t steps() const;
  std::string backend_name() const;  ///< "cpu (AVX-512, 2 threads)" or "cuda (device name)".
  const GridMap& map() const;
  /// SHA-256 over particles by slot and over every step's estimate, hex.
  std::string digest() const;

 protected:
  struct Run;
  explicit PoseFilter(std::unique_ptr<Run> run);

  std::unique_ptr<Run> run_;
};

}  // namespace parloc
