// Every setting of the filters, with its default. The only place where a default is written, but for those of
// the search (common/search/search_config.h) and of the filters on the distance field
// (common/flow/flow_config.h).
// common/io/config.h reads and prints these as YAML; common/filter/config_fields.h lists their names and
// limits.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/filter/backend_choice.h"
#include "common/flow/flow_config.h"
#include "common/search/search_config.h"
#include "common/slam/slam_config.h"

namespace parloc {

enum class MotionForm { seed, thrun };
/// Odometry motion model (SPEC 1; Paz et al. 2012 eq. 6 to 8).
struct MotionConfig {
  MotionForm form = MotionForm::seed;  ///< seed: sigma linear in |delta|; thrun: variance quadratic.
  double alpha1 = 0.2;                 ///< Rotation noise from rotation [1].
  double alpha2 = 0.1;                 ///< Rotation noise from translation [rad/m].
  double alpha3 = 0.2;                 ///< Translation noise from translation [1].
  double alpha4 = 0.1;                 ///< Translation noise from rotation [m/rad].
  double sigma_rot_min_rad = 0.0;      ///< Noise floor of each rotation, only while the robot moves.
  double sigma_trans_min_m = 0.0;      ///< Noise floor of the translation, only while the robot moves.
  double min_translation_m = 0.01;     ///< Below it a step is a turn in place (SPEC 1.1).
  bool symmetric = true;               ///< Driving backwards is not a turn by pi.
  double max_jump_m = 1.0;             ///< A longer odometry step is reported and its noise inflated.
};

enum class ZeroPolicy { invalid, miss };
/// Which beam of a scan its stamp is the time of.
enum class StampAt { first, middle, last };
/// Which beams of a scan are used, and what their values mean (SPEC 0.3).
struct ScanConfig {
  int max_beams = 100;            ///< Evenly spaced in angle.
  int min_beams = 5;              ///< Fewer usable beams: prediction only.
  double laser_min_range = 0.1;   ///< Used where the log gives none [m].
  double laser_max_range = 40.0;  ///< Used where the log gives none [m].
  ZeroPolicy zero_policy = ZeroPolicy::invalid;
  double scan_time = 0.0;             ///< From the first beam to the last, where the log does not say [s].
  StampAt stamp_at = StampAt::first;  ///< As in ROS.
};

/// What the log does not say of one LiDAR, or says wrongly. What is empty is as the log says, then as
/// ScanConfig does.
struct LidarConfig {
  std::string name;                       ///< As the log calls it (Scan::sensor).
  std::optional<double> x{}, y{}, yaw{};  ///< Pose on the robot [m, rad].
  bool upside_down = false;               ///< Mirrored about its own x axis: angles run the other way.
  std::optional<double> min_range{}, max_range{};  ///< [m]
  std::optional<int> max_beams{};
  std::optional<ZeroPolicy> zero_policy{};
  std::optional<double> scan_time{};  ///< [s]
  std::optional<StampAt> stamp_at{};
};

enum class SensorModel { gaussian, s5, beam, class_conditional, likelihood_field, likelihood_field_prob };
/// The others look up end points.
constexpr bool casts_rays(SensorModel m) {
  return m != SensorModel::likelihood_field && m != SensorModel::likelihood_field_prob;
}

enum class RayCaster { skip, dda, fixed_step };
enum class FieldLookup { nearest, bilinear };
/// p(scan | pose, map) (SPEC 3). One group for all models; each uses the keys it knows. These are the values
/// of the likelihood field; default_sensor() has those of the others.
struct SensorConfig {
  SensorModel model = SensorModel::likelihood_field;
  double sigma_hit = 0.1;  ///< Standard deviation of a range (ray models) or of a wall's place (field) [m].
  double z_hit = 0.9, z_short = 0.0, z_max = 0.0, z_rand = 0.1;  ///< Mixture; the sum must be 1.
  double lambda_short = 0.5;                                     ///< [1/m]
  double laser_likelihood_max_dist = 2.0;                        ///< Cap of the distance field [m].
  /// Independent beams that a scan is worth, however many it has: chosen so that the filter's covariance
  /// says how far off it is (docs/results/nees.md).
  double effective_beams = 9.0;
  double tempering = 0.0;            ///< beta of SPEC 3.2 as a number; 0: from effective_beams.
  double s5_epsilon = 1e-3;          ///< Weight of a beam beyond the maximum, measured and expected.
  bool do_beamskip = false;          ///< As in nav2's AMCL, and so the next three.
  double beam_skip_distance = 0.5;   ///< A particle agrees with a beam that ends this close to a wall [m].
  double beam_skip_threshold = 0.3;  ///< Share of the particles that must agree.
  double beam_skip_error_threshold = 0.9;  ///< Of so many beams skipped none is.
  double beam_skip_spread = 0.25;          ///< Standard deviation of the particles' place [m].
  FieldLookup lookup = FieldLookup::bilinear;
  RayCaster caster = RayCaster::skip;
  double fixed_step_cells = 0.5;  ///< Step of the fixed_step caster, in cells.
  bool unknown_blocks = true;     ///< A ray ends at an unknown cell.
};

/// The defaults of a model. A file that chooses a model starts from these.
inline SensorConfig default_sensor(SensorModel model) {
  SensorConfig c;
  c.model = model;
  c.do_beamskip = model == SensorModel::likelihood_field_prob;
  if (!casts_rays(model)) return c;
  c.sigma_hit = 0.2;
  c.effective_beams = model == SensorModel::gaussian || model == SensorModel::s5 ? 0.4 : 6.0;
  if (model == SensorModel::beam) c.z_hit = 0.75, c.z_short = 0.1, c.z_max = 0.05, c.z_rand = 0.1;
  if (model == SensorModel::class_conditional)
    c.z_hit = 0.65, c.z_short = 0.2, c.z_max = 0.05, c.z_rand = 0.1;
  return c;
}

enum class ResampleScheme { systematic, stratified, residual, multinomial, multinomial_linear };
struct ResampleConfig {
  ResampleScheme scheme = ResampleScheme::systematic;
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
  double recovery_alpha_slow = 0.0;    ///< Rates of two running means of a scan's likelihood, per scan ...
  double recovery_alpha_fast = 0.0;    ///< ... both 0: nothing is ever drawn from free space.
  double recovery_margin = 2.0;        ///< The fast mean may fall below the slow one by this factor.
  double expansion_likelihood = 0.0;   ///< Likelihood per beam below which the cloud is widened; 0: never.
  int expansion_scans = 5;             ///< So many such scans in a row.
  double expansion_sigma_xy = 0.5;     ///< Noise of the first widening; it grows by as much each [m].
  double expansion_sigma_theta = 0.3;  ///< [rad]
};

enum class EstimateMode { mean, cluster };
struct EstimateConfig {
  EstimateMode mode = EstimateMode::cluster;  ///< The whole set's mean, or that of its heaviest cluster.
};

/// What surrounds the filter (common/localize/localizer.h); the filter itself knows nothing of it.
struct LocalizeConfig {
  bool health = true;  ///< Judge every estimate. Without it there is no search either.
  bool recover =
      true;  ///< Search the map when lost, and for rivals while it is not sure. Else it only says so.
};

struct FilterConfig {
  std::int64_t particles = 2000;   ///< 1 to 16,777,216.
  std::int64_t min_particles = 0;  ///< Below max_particles: their number adapts. 0: max_particles.
  std::int64_t max_particles = 0;  ///< 0: particles.
  std::uint64_t seed = 1;
  BackendChoice backend = BackendChoice::automatic;
  int threads = 0;                   ///< 0: all cores.
  int device = 0;                    ///< Which CUDA device, as `parloc devices` numbers them.
  double initial_sigma_xy = 0.2;     ///< Spread of a start pose given without one [m].
  double initial_sigma_theta = 0.1;  ///< [rad]
  double update_min_d = 0.0;         ///< Weigh a scan after this much translation [m] ...
  double update_min_a = 0.0;         ///< ... or this much rotation [rad]; both 0: every scan.
  MotionConfig motion;
  ScanConfig scan;
  SensorConfig sensor;
  ResampleConfig resample;
  KldConfig kld;
  RecoveryConfig recovery;
  EstimateConfig estimate;
  LocalizeConfig localize;
  FlowConfig flow;
  SlamConfig slam;
  SearchConfig search;              ///< Its backend, threads and device are those above.
  std::vector<LidarConfig> lidars;  ///< May be empty; in no order.

  std::int64_t most_particles() const { return max_particles > 0 ? max_particles : particles; }
  std::int64_t fewest_particles() const { return min_particles > 0 ? min_particles : most_particles(); }
  bool adapts_particles() const { return fewest_particles() < most_particles(); }
};

}  // namespace parloc
