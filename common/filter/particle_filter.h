// The bootstrap particle filter: predict, weight, normalise, estimate, resample (Paz et al. 2012, algorithm
// 2), and what makes it adaptive: KLD-sampling, augmented recovery, expansion resetting.
#pragma once

#include <optional>
#include <vector>

#include "common/filter/filter_config.h"
#include "common/filter/pose_filter.h"
#include "common/filter/pose_guess.h"

namespace parloc {

struct BeamTable;

class ParticleFilter final : public PoseFilter {
 public:
  /// Throws Error{config} for an impossible configuration, Error{backend} if the backend is not there,
  /// Error{input} for a map without free cells.
  ParticleFilter(const FilterConfig& config, const GridMap& map);

  void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m, double sigma_theta_rad) override;
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
  /// The next scan of each LiDAR is weighed though the robot has moved too little (update_min_d).
  void weigh_next();
  /// First call: no motion. Weighs the scan, unless the robot has moved too little.
  Estimate step(const Pose& odometry, const Scan& scan) override;

  /// The beams of a scan as a step would take them, by the odometry known so far.
  BeamTable beams(const Scan& scan) const;
  const BeamTable& last_beams() const;          ///< Those that the last step weighed.
  const std::optional<Pose>& odometry() const;  ///< Of the last step.
  /// Where the beams of a scan ended, in the base frame at its stamp, decimation apart, by the odometry known
  /// so far.
  std::vector<EndPoint> end_points(const Scan& scan) const;
  const FilterConfig& config() const;

 private:
  struct State;
  State& state();
  const State& state() const;
};

}  // namespace parloc
