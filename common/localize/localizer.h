// Search, track, notice when lost, search again: a particle filter that needs no operator.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/filter/particle_filter.h"
#include "common/localize/health.h"
#include "common/localize/localizer_config.h"
#include "common/localize/modes.h"
#include "common/map/grid_map.h"
#include "common/search/search_config.h"

namespace parloc {

/// What a localizer says after a scan.
struct LocalizerEstimate {
  Estimate filter;          ///< Its pose is in filter.pose.
  Health health;            ///< How far it is to be believed; without `localize.health` that of nothing seen.
  std::vector<Mode> modes;  ///< While `ambiguous`: the places that are possible, most likely first.
  bool searched = false;    ///< The whole map was searched at this scan.
  std::size_t found = 0;    ///< Hypotheses of that search.
};

/// Not thread-safe, one object per robot, as ParticleFilter: calls come one after the other, from any
/// threads; prepare_map() alone may be called beside them. Cannot be copied. Deterministic: the same
/// configuration, map and calls give the same bits on every backend, thread count and instruction set.
class Localizer {
 public:
  /// Throws as ParticleFilter and GlobalSearch. Makes what searches need of the map, which takes a while.
  Localizer(const LocalizerConfig& config, const GridMap& map);
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// The start is known, about, by standard deviations along the map's axes. Throws as ParticleFilter.
  void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m, double sigma_theta_rad);
  /// The same by a whole covariance, map frame.
  void start_at(const Pose& pose_in_map, const Covariance& covariance);
  /// One of several places.
  void start_at(const std::vector<PoseGuess>& guesses);
  /// It is not: the first scan decides. What is known beforehand restricts this and every later search.
  void start_anywhere(const SearchPrior& prior = {});
  void set_seed(std::uint64_t seed);  ///< From the next start on.

  /// In the middle of a run somebody who sees the robot says where it is now ("initialpose" of ROS): it is
  /// believed as a start is, and a search that is under way is given up; odometry, counts and what was learnt
  /// of the LiDARs go on. Throws as ParticleFilter::relocate.
  void relocate(const Pose& pose_in_map, const Covariance& covariance);
  /// The same about several places.
  void relocate(const std::vector<PoseGuess>& guesses);

  /// A map with all that a localizer makes of it. To be moved, not copied.
  class PreparedMap {
   public:
    PreparedMap(PreparedMap&&) noexcept;
    PreparedMap& operator=(PreparedMap&&) noexcept;
    ~PreparedMap();
    /// The map itself.
    const GridMap& map() const;

   private:
    friend class Localizer;
    struct Parts;
    explicit PreparedMap(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
  };
  /// Makes ready what replace_map() needs: takes as long and as much memory as a localizer of its own. The
  /// one call that another thread may make beside the others. Throws as the constructor.
  PreparedMap prepare_map(const GridMap& map) const;
  /// From here on that is the map. Quick: between two scans. The pose stays where it is in the map frame, its
  /// particles and covariance too, and with them whether it is settled and how well scans have fitted; a
  /// search that is under way begins anew, places that a search has found on the old map are forgotten.
  /// Throws as ParticleFilter::replace_map.
  void replace_map(PreparedMap prepared);
  /// Both at once.
  void replace_map(const GridMap& map) { replace_map(prepare_map(map)); }

  void add_odometry(double stamp_s, const Pose& odometry);  ///< As ParticleFilter.
  void weigh_next();                                        ///< As ParticleFilter.
  /// As ParticleFilter, late scans and scan.check_stamps included; throws as that does.
  LocalizerEstimate step(const Pose& odometry, const Scan& scan);
  /// The same with the odometry at the scan's stamp taken from the readings that were added.
  LocalizerEstimate step(const Scan& scan);
  /// As ParticleFilter::predict, with the covariance of the closed loop.
  PoseEstimate predict(double stamp_s) const;

  const ParticleFilter& filter() const;  ///< The filter inside, with everything that it tells.
  std::size_t searches() const;          ///< Since the start.

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
