// What filters say of a robot's pose, and what all of them can that track it from a known start: for loops
// that compare them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/filter/pose/covariance.h"
#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "common/model/beam_counts.h"
#include "common/model/continuous_odometry.h"
#include "common/model/scan.h"

namespace parloc {

/// What one filter step says. The only thing that comes up from the device in a step.
struct Estimate {
  double stamp_s = 0.0;   ///< When the pose was so: the scan's stamp.
  Pose pose;              ///< Of the mode chosen in the configuration.
  Covariance covariance;  ///< Of the same.
  PoseEstimate mean;      ///< All particles.
  PoseEstimate cluster;   ///< The heaviest connected cluster of 0.5 m x 0.5 m x 10 degree bins.
  double n_eff = 0.0;     ///< Effective number of particles: 1 / sum of squared weights, before resampling.
  std::size_t particles = 0;       ///< That were weighed: where their number adapts, it differs by step.
  double p_injected = 0.0;         ///< Share of the next particles that is drawn from free space.
  double beam_likelihood = 0.0;    ///< Of the last scan used: geometric mean over its beams; 0: none yet.
  bool weighted = false;           ///< A scan was used (else prediction only).
  bool resampled = false;          ///< Particles were drawn anew afterwards.
  bool lost = false;               ///< Every particle had weight zero: weights were made uniform.
  bool ambiguous_heading = false;  ///< The mean's heading is undefined; the cluster's was taken.
};

/// A particle as a user sees it: map frame, weight share.
struct Particle {
  float x_m;        ///< Place along the map's x axis.
  float y_m;        ///< And along its y axis.
  float theta_rad;  ///< Heading.
  float weight;     ///< Share of the total, 0 to 1.
};

/// Not thread-safe, one object per filter: a filter may be handed from thread to thread, but what is called
/// on it is called one after the other, const or not. Different filters are independent of each other. Cannot
/// be copied; a moved-from one may only be destroyed or assigned to. Deterministic: the same configuration,
/// map and calls give the same bits on every backend, thread count and instruction set (docs/determinism.md).
///
/// On the CPU a step wakes OpenMP's threads, which afterwards wait for the next by spinning: a process that
/// does other things sets GOMP_SPINCOUNT=3000 (or OMP_WAIT_POLICY=passive) in its environment before it
/// starts, or gives the filter few threads (docs/library.md).
class PoseFilter {
 public:
  virtual ~PoseFilter();
  PoseFilter(PoseFilter&&) noexcept;
  PoseFilter& operator=(PoseFilter&&) noexcept;

  /// Gaussian start, by standard deviations along the map's axes. Throws Error{input} if the pose is not
  /// finite or lies outside the map, or a deviation is negative or not finite.
  void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m, double sigma_theta_rad);
  /// The same by a whole covariance, map frame: a diagonal one gives the bits that the deviations give.
  /// Throws Error{input} likewise, and for one that is not symmetric and positive semidefinite.
  virtual void start_at(const Pose& pose_in_map, const Covariance& covariance) = 0;
  /// From the next start on.
  void set_seed(std::uint64_t seed);
  /// An odometry reading between steps, in any order: how the robot moves while a scan is taken, and
  /// afterwards (predict), and where it was at a scan's stamp (step without odometry). The last two seconds
  /// are remembered, those of the steps among them. To a step with odometry they matter only for scans that
  /// take time; readings up to the last beam's time, given before the step, spare it a guess.
  void add_odometry(double stamp_s, const Pose& odometry);
  /// Moves by the odometry since the last call (first call: not at all) and takes the scan in. `odometry` is
  /// that at the scan's stamp. Scans of several LiDARs (Scan::sensor) are steps of their own, in any order.
  /// Non-finite odometry is skipped and counted. Estimate::weighted tells whether the scan changed anything,
  /// and why_skipped() why not. A scan that comes late, after newer ones, is weighed where the robot was at
  /// its stamp: the particles are moved back by the odometry, and the estimate is of then
  /// (Estimate::stamp_s). With scan.check_stamps one that came twice, or too late for that, is refused.
  /// Throws Error{input} for a scan with numbers that are not finite or arrays that do not fit together,
  /// Error{usage} before a start; then nothing has changed.
  virtual Estimate step(const Pose& odometry, const Scan& scan) = 0;
  /// The same with the odometry at the scan's stamp taken from the readings that were added. Changes nothing
  /// if they do not reach there (their two seconds, and half a second on): why_skipped() says so.
  Estimate step(const Scan& scan);
  /// The last estimate at another time, a little later or earlier: moved by the readings between, and beyond
  /// the last as it ended; its covariance propagated by the motion model. What a robot publishes between
  /// scans. Throws Error{input} for a time more than two seconds from the readings, Error{usage} before the
  /// first step.
  PoseEstimate predict(double stamp_s) const;
  /// The same of any estimate of this filter.
  PoseEstimate predict_from(const PoseEstimate& from, double from_s, double to_s) const;
  /// Throws as a step would for this scan.
  void check(const Scan& scan) const;
  /// Whether the next step would refuse the scan (scan.check_stamps).
  bool refuses(const Scan& scan) const;
  /// How the next step will take its odometry: at the time of its scan, and without jumps. To be called at
  /// most once before that step, with the same; nothing if it is not finite.
  std::optional<OdometryReading> prepare_odometry(double stamp_s, const Pose& odometry);
  /// Of a step without odometry; that step is then given any.
  std::optional<OdometryReading> prepare_odometry(double stamp_s);
  /// The last reading that a step has taken, in the frame that prepare_odometry() gives; none before the
  /// first.
  std::optional<Pose> last_odometry() const;
  /// Why the last step's scan changed nothing; empty if it did.
  const std::string& why_skipped() const;

  /// The particles of the last step (downloads them), if there are any; at most `most`, evenly by slot.
  /// Weights are shares of all.
  std::vector<Particle> particles(std::size_t most = SIZE_MAX) const;
  BeamCounts beam_counts() const;                    ///< Summed since the start, over all LiDARs.
  const std::vector<LidarUse>& lidars_used() const;  ///< By LiDAR, in the order in which they came.
  std::size_t odometry_jumps() const;                ///< Steps that no robot makes (ContinuousOdometry).
  std::size_t odometry_invalid() const;              ///< Steps skipped because the odometry was not finite.
  std::size_t steps() const;                         ///< Since the start, those without a scan among them.
  std::string backend_name() const;                  ///< "cpu (AVX-512, 2 threads)" or "cuda (device name)".
  const GridMap& map() const;                        ///< The one that is localized on.
  /// SHA-256 over particles by slot and over every step's estimate, hex.
  std::string digest() const;

 protected:
  struct Run;
  explicit PoseFilter(std::unique_ptr<Run> run);

  std::unique_ptr<Run> run_;
};

}  // namespace parloc
