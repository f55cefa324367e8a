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
  Estimate filter;  ///< Its pose is in filter.pose.
  Health health;
  std::vector<Mode> modes;  ///< While `ambiguous`: the places that are possible, most likely first.
  bool searched = false;    ///< The whole map was searched at this scan.
  std::size_t found = 0;    ///< Hypotheses of that search.
};

/// Not thread-safe; one object per robot. Deterministic: the same configuration, map and calls give the same
/// bits on every backend, thread count and instruction set.
class Localizer {
 public:
  /// Throws as ParticleFilter and GlobalSearch. Makes what searches need of the map, which takes a while.
  Localizer(const LocalizerConfig& config, const GridMap& map);
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// The start is known, about: as ParticleFilter, or several places that are possible.
  void start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m, double sigma_theta_rad);
  void start_at(const std::vector<PoseGuess>& guesses);
  /// It is not: the first scan decides. What is known beforehand restricts this and every later search.
  void start_anywhere(const SearchPrior& prior = {});
  void set_seed(std::uint64_t seed);  ///< From the next start on.

  void add_odometry(double stamp_s, const Pose& odometry);  ///< As ParticleFilter.
  void weigh_next();                                        ///< As ParticleFilter.
  LocalizerEstimate step(const Pose& odometry, const Scan& scan);

  const ParticleFilter& filter() const;
  std::size_t searches() const;  ///< Since the start.

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
