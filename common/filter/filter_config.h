// Settings of the particle filter.
#pragma once

#include <cstdint>
#include <memory>

#include "common/filter/filter_group.h"
#include "common/filter/steps/step_config.h"
#include "common/model/sensor_config.h"

namespace parloc {

/// How particles are drawn anew by their weights.
enum class ResampleScheme {
  systematic,          ///< One random number for all, at even distances.
  stratified,          ///< One for each, in its part of as many even ones.
  residual,            ///< Whole copies first, what is left over at random.
  multinomial,         ///< Each by itself.
  multinomial_linear,  ///< The same, looked up from the first particle on.
};
/// When and how particles are drawn anew.
struct ResampleConfig {
  ResampleScheme scheme = ResampleScheme::systematic;  ///< How.
  double threshold = 0.5;  ///< Resample when N_eff < threshold * N; 1 or more: every step.
};

/// How many particles are enough (Fox 2003). As many as keep the distance between the particles and what they
/// stand for below pf_err with probability 1 - delta, given how many bins of poses they occupy.
struct KldConfig {
  double pf_err = 0.05;            ///< Kullback-Leibler distance [nat].
  double delta = 0.01;             ///< Probability of a larger one.
  double pf_z = 0.0;               ///< Above 0: the normal quantile itself, as in nav2, in place of delta.
  double bin_size_xy = 0.5;        ///< [m]
  double bin_size_theta = 0.1745;  ///< [rad]; rounded so that a full turn is a whole number of bins.
};

/// What helps a filter that has lost its robot.
struct RecoveryConfig {
  double recovery_alpha_slow = 0.0;    ///< Rate of a slow running mean of a scan's likelihood [1/scan].
  double recovery_alpha_fast = 0.0;    ///< Of a fast one; both 0: nothing is ever drawn from free space.
  double recovery_margin = 2.0;        ///< The fast mean may fall below the slow one by this factor.
  double expansion_likelihood = 0.0;   ///< Likelihood per beam below which the cloud is widened; 0: never.
  int expansion_scans = 5;             ///< So many such scans in a row.
  double expansion_sigma_xy = 0.5;     ///< Noise of the first widening; it grows by as much each [m].
  double expansion_sigma_theta = 0.3;  ///< [rad]
};

/// Which pose stands for the particles.
enum class EstimateMode {
  mean,     ///< That of all.
  cluster,  ///< That of the heaviest cluster.
};
/// What is reported.
struct EstimateConfig {
  EstimateMode mode = EstimateMode::cluster;  ///< The whole set's mean, or that of its heaviest cluster.
};

/// Everything that a ParticleFilter reads.
struct FilterConfig : StepConfig {
  std::int64_t particles = 2000;       ///< 1 to 16,777,216.
  std::int64_t min_particles = 0;      ///< Below max_particles: their number adapts. 0: max_particles.
  std::int64_t max_particles = 0;      ///< 0: particles.
  double initial_sigma_xy = 0.2;       ///< Spread of a start pose given without one [m].
  double initial_sigma_theta = 0.1;    ///< [rad]
  SensorConfig sensor;                 ///< How well a scan fits the map at a pose.
  ResampleConfig resample;             ///< When and how particles are drawn anew.
  KldConfig kld;                       ///< How many are enough, where their number adapts.
  RecoveryConfig recovery;             ///< What helps when the robot is lost.
  EstimateConfig estimate;             ///< Which pose is reported.
  std::shared_ptr<FilterGroup> group;  ///< No setting: filters of the process that step together; or null.

  /// The number at the start, for which there is memory.
  std::int64_t most_particles() const { return max_particles > 0 ? max_particles : particles; }
  /// Where the number adapts, it does not fall below this.
  std::int64_t fewest_particles() const { return min_particles > 0 ? min_particles : most_particles(); }
  /// Whether the number adapts (KldConfig).
  bool adapts_particles() const { return fewest_particles() < most_particles(); }
};

/// Limits of every setting, and the rules between them. Throws Error{config} naming the setting.
void validate(const FilterConfig& config);

}  // namespace parloc
