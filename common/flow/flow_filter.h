// Localization on the distance field from a known start: Kalman filters, and the particle flows of Daum and
// Huang (docs/flow.md).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/filter/pose_filter.h"
#include "common/flow/flow_filter_config.h"

namespace parloc {

/// One of the filters of FlowMethod. They differ in what a scan does, and share all else: motion, beams,
/// field, backends. Kalman filters are the ones without particles. Only pfpf reads `resample`.
/// Every scan counts, whatever update_min_d and update_min_a say.
class FlowFilter final : public PoseFilter {
 public:
  /// Throws as ParticleFilter.
  FlowFilter(FlowMethod method, const FlowFilterConfig& config, const GridMap& map);
  ~FlowFilter() override;

  void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m, double sigma_theta_rad) override;
  void set_seed(std::uint64_t seed) override;
  void add_odometry(double stamp_s, const Pose& odometry) override;
  /// Estimate::mean has the filter's covariance (flow.prior), Estimate::cluster that of the particles.
  /// Non-finite odometry is skipped and counted. Throws Error{input} for a scan whose arrays do not fit
  /// together.
  Estimate step(const Pose& odometry, const Scan& scan) override;
  std::string why_skipped() const override;
  BeamCounts beam_counts() const override;
  std::size_t steps() const override;
  std::string backend_name() const override;
  std::string digest() const override;

  /// Of the last step, at most `most` of them, evenly by slot; none for Kalman filters.
  std::vector<Particle> particles(std::size_t most = SIZE_MAX) const;
  const std::vector<LidarUse>& lidars_used() const;  ///< By LiDAR, in the order in which they came.
  std::size_t odometry_jumps() const;                ///< Steps longer than motion.max_jump_m.
  std::size_t odometry_invalid() const;              ///< Steps skipped because the odometry was not finite.
  /// Steps in pseudo-time lag behind: scans taken in by Euler steps where the prior is so much wider than the
  /// measurement (s / r above 100) that they leave the cloud twice too wide or more.
  std::size_t stiff_scans() const;
  const FlowFilterConfig& config() const;
  const GridMap& map() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
