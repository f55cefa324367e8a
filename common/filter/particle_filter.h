// The bootstrap particle filter: predict, weight, normalise, estimate, resample (Paz et al. 2012, algorithm
// 2), and what makes it adaptive: KLD-sampling, augmented recovery, expansion resetting.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/filter/filter_config.h"
#include "common/filter/pose_guess.h"
#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "common/model/beam_counts.h"
#include "common/model/continuous_odometry.h"
#include "common/model/scan.h"

namespace parloc {

struct BeamTable;

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
class ParticleFilter {
 public:
  /// Throws Error{config} for an impossible configuration, Error{backend} if the backend is not there,
  /// Error{input} for a map without free cells.
  ParticleFilter(const FilterConfig& config, const GridMap& map);
  ~ParticleFilter();
  ParticleFilter(ParticleFilter&&) noexcept;
  ParticleFilter& operator=(ParticleFilter&&) noexcept;

  /// Gaussian start. Throws Error{input} if the pose is not finite or lies outside the map.
  void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m, double sigma_theta_rad);
  /// Uniform over the free cells.
  void start_anywhere();

  /// About several guesses, each with its share of the particles. Throws Error{input} if there is none, or
  /// one is not finite.
  void start_at(const std::vector<PoseGuess>& guesses);
  /// Puts the particles there in the middle of a run, which goes on: the next step does not move them if its
  /// odometry is this one. Throws as start_at.
  void relocate(const std::vector<PoseGuess>& guesses, const Pose& odometry);
  /// Before a step: puts `share` of the particles, above 0 and below 1, about a place where the wheels may
  /// have slipped to, with weights that let the scan decide (propose_particles). Throws as start_at.
  void propose(const PoseGuess& guess, double share, const SlipPrior& slip);
  /// Whether a scan of that LiDAR would be weighed in a step with this odometry (update_min_d).
  bool counts(const Pose& odometry, const Scan& scan) const;
  /// From the next start on.
  void set_seed(std::uint64_t seed);

  /// An odometry reading between steps, in any order: how the robot moves while a scan is taken. Matters only
  /// for scans that take time, and those also know the odometry of the steps; readings up to the last beam's
  /// time, given before the step, spare it a guess.
  void add_odometry(double stamp_s, const Pose& odometry);

  /// Moves by the odometry since the last call and weighs the scan (first call: no motion). `odometry` is
  /// that at the scan's stamp. Scans of several LiDARs (Scan::sensor) are steps of their own, in any order.
  /// Non-finite odometry is skipped and counted. Throws Error{input} for a scan whose arrays do not fit
  /// together.
  Estimate step(const Pose& odometry, const Scan& scan);
  /// How the next step will take its odometry: at the time of its scan, and without jumps. To be called once
  /// before that step, with the same; nothing if it is not finite.
  std::optional<OdometryReading> prepare_odometry(double stamp_s, const Pose& odometry);

  /// The particles of the last step (downloads them); at most `most`, evenly by slot. Weights are shares of
  /// all.
  std::vector<Particle> particles(std::size_t most = SIZE_MAX) const;
  /// The beams of a scan as a step would take them, by the odometry known so far.
  BeamTable beams(const Scan& scan) const;
  const BeamTable& last_beams() const;               ///< Those that the last step weighed.
  const std::optional<Pose>& odometry() const;       ///< Of the last step.
  BeamCounts beam_counts() const;                    ///< Summed since the start, over all LiDARs.
  const std::vector<LidarUse>& lidars_used() const;  ///< By LiDAR, in the order in which they came.
  /// Where the beams of a scan ended, in the base frame at its stamp, decimation apart, by the odometry known
  /// so far.
  std::vector<EndPoint> end_points(const Scan& scan) const;
  std::size_t odometry_jumps() const;    ///< Steps that no robot makes (ContinuousOdometry).
  std::size_t odometry_invalid() const;  ///< Steps skipped because the odometry was not finite.
  std::size_t steps() const;
  std::string backend_name() const;  ///< "cpu (AVX-512, 2 threads)" or "cuda (device name)".
  const FilterConfig& config() const;
  const GridMap& map() const;
  /// SHA-256 over particles by slot and over every step's estimate, hex.
  std::string digest() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
