// Localization on the distance field from a known start: Kalman filters, and the particle flows of Daum and
// Huang (docs/flow.md).
#pragma once

#include <cstddef>

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

  using PoseFilter::start_at;
  using PoseFilter::step;
  void start_at(const Pose& pose_in_map, const Covariance& covariance) override;
  /// Estimate::mean has the filter's covariance (flow.prior), Estimate::cluster that of the particles.
  Estimate step(const Pose& odometry, const Scan& scan) override;

  /// Steps in pseudo-time lag behind: scans taken in by Euler steps where the prior is so much wider than the
  /// measurement (s / r above 100) that they leave the cloud twice too wide or more.
  std::size_t stiff_scans() const;
  /// What the filter was made with, but for a seed that was set.
  const FlowFilterConfig& config() const;

 private:
  struct State;
  State& state();
  const State& state() const;
};

}  // namespace parloc
