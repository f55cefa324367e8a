// The bootstrap particle filter: predict, weight, normalise, estimate, resample (Paz et al. 2012, algorithm
// 2), and what makes it adaptive: KLD-sampling, augmented recovery, expansion resetting.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "common/filter/filter_config.h"
#include "common/filter/pose/pose_guess.h"
#include "common/filter/pose_filter.h"
#include "common/model/beam_table.h"

namespace parloc {

/// Tracks a pose on a map with particles. Threads, copies and determinism as PoseFilter says.
class ParticleFilter final : public PoseFilter {
 public:
  /// Throws Error{config} for an impossible configuration, Error{backend} if the backend is not there,
  /// Error{input} for a map that is none (validate) or has no free cell.
  ParticleFilter(const FilterConfig& config, const GridMap& map);

  using PoseFilter::start_at;
  using PoseFilter::step;
  void start_at(const Pose& pose_in_map, const Covariance& covariance) override;
  /// Uniform over the free cells.
  void start_anywhere();
  /// About several guesses, each with its share of the particles. Throws Error{input} if there is none, or
  /// one is not finite or lies outside the map.
  void start_at(const std::vector<PoseGuess>& guesses);

  /// Puts the particles there in the middle of a run, which goes on: the robot is there now, at the odometry
  /// of the last step, as an operator says who sees it. Throws as start_at, and Error{usage} before a start.
  void relocate(const Pose& pose_in_map, const Covariance& covariance);
  /// The same about several places, as start_at has them.
  void relocate(const std::vector<PoseGuess>& guesses);
  /// The same where the robot is there at this odometry: the next step does not move the particles if its own
  /// is that. Guesses may lie outside the map. Throws Error{input} for one that is not finite.
  void relocate(const std::vector<PoseGuess>& guesses, const Pose& odometry);

  /// A map with all that a filter makes of it. To be moved, not copied.
  class PreparedMap {
   public:
    PreparedMap(PreparedMap&&) noexcept;
    PreparedMap& operator=(PreparedMap&&) noexcept;
    ~PreparedMap();
    /// The map itself.
    const GridMap& map() const;

   private:
    friend class ParticleFilter;
    struct Parts;
    explicit PreparedMap(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
  };
  /// Makes ready what replace_map() needs: takes as long and as much memory as a filter of its own. The one
  /// call that another thread may make while this filter steps. Throws as the constructor.
  PreparedMap prepare_map(const GridMap& map) const;
  /// From here on that is the map: the particles stay where they are in the map frame, wherever its grid
  /// lies, those that are outside among them, and the run goes on. Quick: between two scans. The running
  /// means of `recovery` begin anew. Throws Error{usage} for what another filter has prepared.
  void replace_map(PreparedMap prepared);
  /// Both at once.
  void replace_map(const GridMap& map) { replace_map(prepare_map(map)); }

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
  /// What the filter was made with, but for a seed that was set.
  const FilterConfig& config() const;

 private:
  struct State;
  State& state();
  const State& state() const;
};

}  // namespace parloc
