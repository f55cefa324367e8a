// The table of all settings: group, key, place in FilterConfig, limits or choices, and what it means.
// Readers, printers and checks of a configuration visit this table; defaults are in common/filter/config.h
// alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "common/filter/config.h"

namespace parloc {

/// One setting. `group` is empty for a top-level key.
struct Setting {
  const char* group;
  const char* key;
  const char* doc;  ///< One line, with the unit in brackets.
};

/// The values a number may take: low to high, both included unless `above_low`.
template <class Number>
struct Limits {
  Number low;
  Number high;
  bool above_low = false;  ///< low itself is not allowed.
};

/// A named value of an enumeration.
template <class Enum>
struct Choice {
  const char* name;
  Enum value;
};

/// A group of settings, in the order of the printed configuration.
struct SettingGroup {
  const char* name;
  const char* doc;
};

/// The group of the LiDARs: "name:" lines with a group of settings each (visit_lidar_settings).
inline constexpr SettingGroup kLidars{
    "lidars",
    "What the log does not say of a LiDAR, or says wrongly: an entry for each, by its name in the log."};

inline constexpr std::array<SettingGroup, 11> kSettingGroups{{
    {"motion", "How the robot moves: odometry motion model."},
    {"scan", "Which beams of a scan are used, and what their values mean."},
    {"sensor", "How well a scan fits the map at a pose. Each model uses the keys it knows."},
    {"resample", "When and how particles are drawn anew."},
    {"kld", "How many particles are enough, where min_particles is below max_particles (KLD-sampling)."},
    {"recovery", "What helps a filter that has lost its robot. Off by default."},
    {"estimate", "Which pose is reported."},
    {"localize", "What watches the filter, and what is done when it is lost (docs/localize.md)."},
    {"flow",
     "Kalman filters and particle flows on the distance field (docs/flow.md); the others do not read it."},
    {"slam", "Mapping without a map (docs/slam.md); the filters on a map do not read it."},
    {"search", "The search of the whole map (docs/locate.md)."},
}};

inline constexpr std::array<Choice<BackendChoice>, 3> kBackends{
    {{"auto", BackendChoice::automatic}, {"cpu", BackendChoice::cpu}, {"cuda", BackendChoice::cuda}}};
inline constexpr std::array<Choice<MotionForm>, 2> kMotionForms{
    {{"seed", MotionForm::seed}, {"thrun", MotionForm::thrun}}};
inline constexpr std::array<Choice<ZeroPolicy>, 2> kZeroPolicies{
    {{"invalid", ZeroPolicy::invalid}, {"miss", ZeroPolicy::miss}}};
inline constexpr std::array<Choice<StampAt>, 3> kStampAts{
    {{"first", StampAt::first}, {"middle", StampAt::middle}, {"last", StampAt::last}}};
inline constexpr std::array<Choice<SensorModel>, 6> kSensorModels{
    {{"gaussian", SensorModel::gaussian},
     {"s5", SensorModel::s5},
     {"beam", SensorModel::beam},
     {"class_conditional", SensorModel::class_conditional},
     {"likelihood_field", SensorModel::likelihood_field},
     {"likelihood_field_prob", SensorModel::likelihood_field_prob}}};
inline constexpr std::array<Choice<FieldLookup>, 2> kFieldLookups{
    {{"nearest", FieldLookup::nearest}, {"bilinear", FieldLookup::bilinear}}};
inline constexpr std::array<Choice<RayCaster>, 3> kRayCasters{
    {{"skip", RayCaster::skip}, {"dda", RayCaster::dda}, {"fixed_step", RayCaster::fixed_step}}};
inline constexpr std::array<Choice<ResampleScheme>, 5> kResampleSchemes{
    {{"systematic", ResampleScheme::systematic},
     {"stratified", ResampleScheme::stratified},
     {"residual", ResampleScheme::residual},
     {"multinomial", ResampleScheme::multinomial},
     {"multinomial_linear", ResampleScheme::multinomial_linear}}};
inline constexpr std::array<Choice<EstimateMode>, 2> kEstimateModes{
    {{"mean", EstimateMode::mean}, {"cluster", EstimateMode::cluster}}};

inline constexpr std::array<Choice<FlowIntegrator>, 3> kFlowIntegrators{
    {{"auto", FlowIntegrator::automatic},
     {"closed_form", FlowIntegrator::closed_form},
     {"euler", FlowIntegrator::euler}}};
inline constexpr std::array<Choice<FlowSchedule>, 3> kFlowSchedules{
    {{"uniform", FlowSchedule::uniform},
     {"exponential", FlowSchedule::exponential},
     {"contract", FlowSchedule::contract}}};
inline constexpr std::array<Choice<FlowPrior>, 3> kFlowPriors{
    {{"recentred", FlowPrior::recentred}, {"ekf", FlowPrior::ekf}, {"sample", FlowPrior::sample}}};
inline constexpr std::array<Choice<FieldInterpolation>, 2> kFieldInterpolations{
    {{"bilinear", FieldInterpolation::bilinear}, {"cubic", FieldInterpolation::cubic}}};
inline constexpr std::array<Choice<FlowGate>, 3> kFlowGates{
    {{"off", FlowGate::off}, {"inflate", FlowGate::inflate}, {"reject", FlowGate::reject}}};

inline constexpr std::array<Choice<SlamProposal>, 3> kSlamProposals{{{"motion", SlamProposal::motion},
                                                                     {"scan_match", SlamProposal::scan_match},
                                                                     {"gaussian", SlamProposal::gaussian}}};

inline constexpr std::array<Choice<SlamOdometry>, 2> kSlamOdometries{
    {{"recorded", SlamOdometry::recorded}, {"scans", SlamOdometry::scans}}};

/// Calls `visit` once per setting, in the order of the printed configuration (top level first, then by
/// group), with (Setting, number&, Limits<number>) for int, int64, uint64 and double; (Setting, bool&);
/// (Setting, enum&, array of Choice). `Config` is FilterConfig or const FilterConfig.
template <class Config, class Visitor>
void visit_settings(Config& c, Visitor&& visit) {
  using Real = Limits<double>;
  using Int = Limits<int>;
  visit(Setting{"", "particles", "Number of particles"}, c.particles, Limits<std::int64_t>{1, 16'777'216});
  visit(Setting{"", "min_particles", "Fewest, if the number is to adapt; 0: max_particles"}, c.min_particles,
        Limits<std::int64_t>{0, 16'777'216});
  visit(Setting{"", "max_particles", "Most, and the number at the start; 0: as particles"}, c.max_particles,
        Limits<std::int64_t>{0, 16'777'216});
  visit(Setting{"", "seed", "Seed of all random numbers: same seed, same answer"}, c.seed,
        Limits<std::uint64_t>{0, std::numeric_limits<std::uint64_t>::max()});
  visit(Setting{"", "backend", "auto takes a CUDA device if there is one"}, c.backend, kBackends);
  visit(Setting{"", "threads", "CPU threads; 0: all cores"}, c.threads, Int{0, 1024});
  visit(Setting{"", "device", "Which CUDA device, as parloc devices numbers them"}, c.device, Int{0, 1023});
  visit(Setting{"", "initial_sigma_xy", "Spread of a start pose given without one [m]"}, c.initial_sigma_xy,
        Real{0, 1000});
  visit(Setting{"", "initial_sigma_theta", "The same for its heading [rad]"}, c.initial_sigma_theta,
        Real{0, 10});
  visit(Setting{"", "update_min_d",
                "Weigh a scan after this much translation [m]; 0 here and below: every scan"},
        c.update_min_d, Real{0, 100});
  visit(Setting{"", "update_min_a", "... or after this much rotation [rad]"}, c.update_min_a, Real{0, 100});

  auto& m = c.motion;
  visit(Setting{"motion", "form", "seed: sigma linear in the motion; thrun: variance quadratic (as AMCL)"},
        m.form, kMotionForms);
  visit(Setting{"motion", "alpha1", "Rotation noise from rotation [1]"}, m.alpha1, Real{0, 100});
  visit(Setting{"motion", "alpha2", "Rotation noise from translation [rad/m]"}, m.alpha2, Real{0, 100});
  visit(Setting{"motion", "alpha3", "Translation noise from translation [1]"}, m.alpha3, Real{0, 100});
  visit(Setting{"motion", "alpha4", "Translation noise from rotation [m/rad]"}, m.alpha4, Real{0, 100});
  visit(Setting{"motion", "sigma_rot_min_rad",
                "Noise floor of each rotation, only while the robot moves [rad]"},
        m.sigma_rot_min_rad, Real{0, 10});
  visit(Setting{"motion", "sigma_trans_min_m",
                "Noise floor of the translation, only while the robot moves [m]"},
        m.sigma_trans_min_m, Real{0, 10});
  visit(Setting{"motion", "min_translation_m", "A shorter step is a turn in place [m]"}, m.min_translation_m,
        Real{0, 10});
  visit(Setting{"motion", "symmetric", "Driving backwards is not a turn by pi"}, m.symmetric);
  visit(Setting{"motion", "max_jump_m", "A longer odometry step is reported and its noise inflated [m]"},
        m.max_jump_m, Real{0, 1000, true});

  auto& s = c.scan;
  visit(Setting{"scan", "max_beams", "Beams used of a scan, evenly spaced in angle"}, s.max_beams,
        Int{1, 4096});
  visit(Setting{"scan", "min_beams", "Fewer usable beams: prediction only"}, s.min_beams, Int{1, 4096});
  visit(Setting{"scan", "laser_min_range", "Shortest range, where the log gives none [m]"}, s.laser_min_range,
        Real{0, 1000});
  visit(Setting{"scan", "laser_max_range", "Longest range, where the log gives none [m]"}, s.laser_max_range,
        Real{0, 1000, true});
  visit(Setting{"scan", "zero_policy", "What a range of exactly 0 means: a broken beam, or no return"},
        s.zero_policy, kZeroPolicies);
  visit(Setting{"scan", "scan_time", "From a scan's first beam to its last, where the log gives none [s]"},
        s.scan_time, Real{0, 1});
  visit(Setting{"scan", "stamp_at", "The beam that a scan's stamp is the time of"}, s.stamp_at, kStampAts);

  auto& z = c.sensor;
  visit(Setting{"sensor", "model", "The first four cast rays, the others look up end points"}, z.model,
        kSensorModels);
  visit(Setting{"sensor", "sigma_hit", "Standard deviation of a range, or of a wall's place (field) [m]"},
        z.sigma_hit, Real{0.001, 10});
  visit(Setting{"sensor", "z_hit", "Share of beams that end at the map's walls; the four shares sum to 1"},
        z.z_hit, Real{0, 1});
  visit(Setting{"sensor", "z_short", "Share of beams that something else stops (beam, class_conditional)"},
        z.z_short, Real{0, 1});
  visit(Setting{"sensor", "z_max", "Share of beams that never return (beam, class_conditional)"}, z.z_max,
        Real{0, 1});
  visit(Setting{"sensor", "z_rand", "Share of beams that say nothing"}, z.z_rand, Real{0, 1});
  visit(Setting{"sensor", "lambda_short", "Decay of the short beams (beam, class_conditional) [1/m]"},
        z.lambda_short, Real{0, 100, true});
  visit(Setting{"sensor", "laser_likelihood_max_dist", "Cap of the distance to a wall (field) [m]"},
        z.laser_likelihood_max_dist, Real{0.01, 100});
  visit(Setting{"sensor", "effective_beams", "Independent beams that a scan is worth, however many it has"},
        z.effective_beams, Real{0, 4096, true});
  visit(Setting{"sensor", "tempering", "Exponent of a scan's likelihood; 0: effective_beams / beams"},
        z.tempering, Real{0, 1});
  visit(Setting{"sensor", "s5_epsilon", "Weight of a beam beyond the maximum, measured and expected (s5)"},
        z.s5_epsilon, Real{1e-30, 1});
  visit(Setting{"sensor", "do_beamskip", "Skip beams that few particles agree with (likelihood_field_prob)"},
        z.do_beamskip);
  visit(
      Setting{"sensor", "beam_skip_distance", "A particle agrees with a beam that ends this near a wall [m]"},
      z.beam_skip_distance, Real{0.001, 100});
  visit(Setting{"sensor", "beam_skip_threshold", "Share of the particles that must agree with a beam"},
        z.beam_skip_threshold, Real{0, 1});
  visit(Setting{"sensor", "beam_skip_error_threshold",
                "All beams count if this share of them would be skipped"},
        z.beam_skip_error_threshold, Real{0, 1});
  visit(
      Setting{"sensor", "beam_skip_spread", "Skip only while the particles' standard deviation is less [m]"},
      z.beam_skip_spread, Real{0, 1000});
  visit(Setting{"sensor", "lookup", "How the distance field is read (field)"}, z.lookup, kFieldLookups);
  visit(Setting{"sensor", "caster", "skip and dda are exact and equal; fixed_step is the 2012 paper's"},
        z.caster, kRayCasters);
  visit(Setting{"sensor", "fixed_step_cells", "Step of the fixed_step caster [cells]"}, z.fixed_step_cells,
        Real{0.01, 10});
  visit(Setting{"sensor", "unknown_blocks", "A ray ends at an unknown cell"}, z.unknown_blocks);

  visit(Setting{"resample", "scheme", "How particles are drawn"}, c.resample.scheme, kResampleSchemes);
  visit(Setting{"resample", "threshold", "Draw when N_eff < threshold * N; 1 or more: every step"},
        c.resample.threshold, Real{0, 1000});

  auto& k = c.kld;
  visit(Setting{"kld", "pf_err", "Distance between the particles and what they stand for [nat]"}, k.pf_err,
        Real{0.0001, 1});
  visit(Setting{"kld", "delta", "Probability of a larger distance"}, k.delta, Real{1e-6, 0.5});
  visit(Setting{"kld", "pf_z", "The normal quantile 1 - delta itself, as nav2 has it; 0: from delta"}, k.pf_z,
        Real{0, 5});
  visit(Setting{"kld", "bin_size_xy", "Side of a bin of poses [m]"}, k.bin_size_xy, Real{0.01, 100});
  visit(Setting{"kld", "bin_size_theta", "... and its heading; a full turn has a whole number of them [rad]"},
        k.bin_size_theta, Real{0.01, 6.2832});

  auto& r = c.recovery;
  visit(Setting{"recovery", "recovery_alpha_slow", "Rate of the slow mean of a scan's likelihood; 0: off"},
        r.recovery_alpha_slow, Real{0, 0.99});
  visit(
      Setting{"recovery", "recovery_alpha_fast", "... of the fast one: below the slow, free space is tried"},
      r.recovery_alpha_fast, Real{0, 0.99});
  visit(Setting{"recovery", "recovery_margin", "... by so many times; 1: as soon as it is below (nav2)"},
        r.recovery_margin, Real{1, 1000});
  visit(Setting{"recovery", "expansion_likelihood", "Likelihood per beam that widens the cloud; 0: off"},
        r.expansion_likelihood, Real{0, 1000});
  visit(Setting{"recovery", "expansion_scans", "... after so many scans below it in a row"},
        r.expansion_scans, Int{1, 100000});
  visit(Setting{"recovery", "expansion_sigma_xy", "Noise of the first widening; grows by as much each [m]"},
        r.expansion_sigma_xy, Real{0, 100});
  visit(Setting{"recovery", "expansion_sigma_theta", "... of the heading [rad]"}, r.expansion_sigma_theta,
        Real{0, 10});

  visit(Setting{"estimate", "mode", "The mean of all particles, or of their heaviest cluster"},
        c.estimate.mode, kEstimateModes);

  visit(Setting{"localize", "health", "Say how sure the pose is; false: the bare filter, without any search"},
        c.localize.health);
  visit(Setting{"localize", "recover", "Search the map when lost; false: only say so"}, c.localize.recover);

  auto& f = c.flow;
  visit(Setting{"flow", "max_beams", "Beams used of a scan, in place of scan.max_beams"}, f.max_beams,
        Int{1, 4096});
  visit(Setting{"flow", "steps", "Pseudo-time steps; the field is linearised anew before each"}, f.steps,
        Int{1, kMostFlowSteps});
  visit(Setting{"flow", "integrator", "Of a step; auto: euler for edh, else closed_form (naedh: always)"},
        f.integrator, kFlowIntegrators);
  visit(Setting{"flow", "schedule", "Equal steps, steps that grow by ratio, or of equal contraction"},
        f.schedule, kFlowSchedules);
  visit(Setting{"flow", "ratio", "Of an exponential step to the one before"}, f.ratio, Real{0.1, 10});
  visit(Setting{"flow", "prior", "Covariance: recursion about the particles' mean, an EKF's, or theirs"},
        f.prior, kFlowPriors);
  visit(Setting{"flow", "interpolation", "Of the distance field between cells"}, f.interpolation,
        kFieldInterpolations);
  visit(Setting{"flow", "max_dist", "From here on a beam's end pulls nowhere [m]"}, f.max_dist,
        Real{0, 100, true});
  visit(Setting{"flow", "sigma_range", "Standard deviation of a range [m]"}, f.sigma_range, Real{0, 10});
  visit(Setting{"flow", "sigma_psi_cells", "Noise floor of a scan's mean distance [cells]; 0: as published"},
        f.sigma_psi_cells, Real{0, 100});
  visit(Setting{"flow", "gate", "What becomes of a scan beyond gate_nis: nothing, more noise, or not used"},
        f.gate, kFlowGates);
  visit(Setting{"flow", "gate_nis", "Innovation squared over its variance"}, f.gate_nis, Real{0, 1e6, true});
  visit(Setting{"flow", "z_score", "Leave out beams whose distance is farther out than this; 0: none"},
        f.z_score, Real{0, 1000});
  visit(Setting{"flow", "map_sigma_cells", "ekf_beams: standard deviation of a wall's place [cells]"},
        f.map_sigma_cells, Real{0.01, 100});
  visit(Setting{"flow", "beta", "ekf_beams: exponent of a beam's likelihood"}, f.beta, Real{0, 1, true});
  visit(Setting{"flow", "iterations", "ekf_beams: at most"}, f.iterations, Int{1, 100});
  visit(Setting{"flow", "pfpf_sigma_xy", "pfpf: motion noise besides, whatever the motion [m]"},
        f.pfpf_sigma_xy, Real{0.0001, 10});
  visit(Setting{"flow", "pfpf_sigma_theta", "... of the heading [rad]"}, f.pfpf_sigma_theta,
        Real{0.0001, 10});

  auto& l = c.slam;
  visit(Setting{"slam", "particles", "Each with a map of its own"}, l.particles,
        Limits<std::int64_t>{1, 65'535});
  visit(Setting{"slam", "proposal", "From odometry alone, the best fit near it, or drawn around that"},
        l.proposal, kSlamProposals);
  visit(Setting{"slam", "odometry", "As recorded, or from the scans alone"}, l.odometry, kSlamOdometries);
  visit(Setting{"slam", "max_beams", "Beams used of a scan, in place of scan.max_beams"}, l.max_beams,
        Int{1, static_cast<int>(kMostSlamBeams)});
  visit(Setting{"slam", "resolution", "Cell size of the maps [m]"}, l.resolution, Real{0.005, 1});
  visit(Setting{"slam", "usable_range", "Beams are cut here: farther ends are not used [m]"}, l.usable_range,
        Real{0.1, 200});
  visit(Setting{"slam", "update_min_d", "Take a scan in after this much translation [m]"}, l.update_min_d,
        Real{0, 100});
  visit(Setting{"slam", "update_min_a", "... or after this much rotation [rad]"}, l.update_min_a,
        Real{0, 100});
  visit(Setting{"slam", "resample_threshold", "Resample when N_eff < threshold * N; 1: every time"},
        l.resample_threshold, Real{0, 1});
  visit(Setting{"slam", "beta_weight", "Exponent of a scan's likelihood in the weights"}, l.beta_weight,
        Real{0, 1, true});
  visit(Setting{"slam", "beta_proposal", "... in the gaussian proposal"}, l.beta_proposal, Real{0, 1, true});
  visit(Setting{"slam", "search_xy", "The matcher first searches all poses so far around [m]"}, l.search_xy,
        Real{0, 5});
  visit(Setting{"slam", "search_theta", "... [rad]; both 0: it only climbs"}, l.search_theta,
        Real{0, 3.1416});
  visit(Setting{"slam", "search_bias", "Score per beam that a pose at its rim must have more"}, l.search_bias,
        Real{0, 1});
  visit(Setting{"slam", "step_xy", "First step of the scan matcher [m]"}, l.step_xy, Real{0, 1, true});
  visit(Setting{"slam", "step_theta", "... [rad]"}, l.step_theta, Real{0, 1, true});
  visit(Setting{"slam", "iterations", "Times that it halves its steps"}, l.iterations, Int{1, 20});
  visit(Setting{"slam", "sigma_score", "Of the matcher's score, exp(-d^2 / sigma) [m^2]"}, l.sigma_score,
        Real{0, 10, true});
  visit(Setting{"slam", "sigma_likelihood", "Of a beam's log-likelihood, -d^2 / sigma [m^2]"},
        l.sigma_likelihood, Real{0, 10, true});
  visit(Setting{"slam", "min_score", "Score per beam below which matching has failed"}, l.min_score,
        Real{0, 1});
  visit(Setting{"slam", "box_xy", "gaussian: half the box that is looked at [m]"}, l.box_xy,
        Real{0, 1, true});
  visit(Setting{"slam", "box_theta", "... [rad]"}, l.box_theta, Real{0, 1, true});
  visit(Setting{"slam", "motion_floor_xy", "Motion noise besides, whatever the motion [m]"},
        l.motion_floor_xy, Real{0, 10, true});
  visit(Setting{"slam", "motion_floor_theta", "... [rad]"}, l.motion_floor_theta, Real{0, 10, true});
  visit(Setting{"slam", "occupied_above", "Share of beams ending there from which a cell is a wall"},
        l.occupied_above, Real{0, 1});
  visit(
      Setting{"slam", "close_loops", "Distribute over the way what loops leave over, and draw the map anew"},
      l.close_loops);
  visit(Setting{"slam", "memory_mib", "Most that the tiles of all maps take [MiB]; 0: no limit"},
        l.memory_mib, Int{0, 10'000'000});

  visit(Setting{"search", "cell_m", "Finer cells of the map are put together to such [m]"}, c.search.cell_m,
        Real{0, 10, true});
  visit(Setting{"search", "beams", "Hits that the exhaustive part looks at"}, c.search.beams, Int{1, 256});
  visit(Setting{"search", "least_score", "How close hits end to walls, 0 to 1: below it a place is none"},
        c.search.least_score, Real{0, 1});
  visit(Setting{"search", "candidates", "Places that rays are cast for"}, c.search.candidates,
        Int{10, 10000});
}

/// The same for one LiDAR's settings, most of which are optional: (Setting, optional<number>&,
/// Limits<number>), (Setting, optional<enum>&, array of Choice), (Setting, bool&). `group` is what the
/// fields' group is to be.
template <class Lidar, class Visitor>
void visit_lidar_settings(Lidar& l, const char* group, Visitor&& visit) {
  using Real = Limits<double>;
  visit(Setting{group, "x", "Place on the robot, ahead [m]; what is left out here is as the log says"}, l.x,
        Real{-100, 100});
  visit(Setting{group, "y", "... to the left [m]"}, l.y, Real{-100, 100});
  visit(Setting{group, "yaw", "... and where its angle 0 looks, counter-clockwise [rad]"}, l.yaw,
        Real{-6.3, 6.3});
  visit(Setting{group, "upside_down", "Mirrored about its own x axis: its angles run clockwise"},
        l.upside_down);
  visit(Setting{group, "min_range", "Shortest range [m]"}, l.min_range, Real{0, 1000});
  visit(Setting{group, "max_range", "Longest range [m]"}, l.max_range, Real{0, 1000, true});
  visit(Setting{group, "zero_policy", "As scan.zero_policy"}, l.zero_policy, kZeroPolicies);
  visit(Setting{group, "max_beams", "As scan.max_beams"}, l.max_beams, Limits<int>{1, 4096});
  visit(Setting{group, "scan_time", "As scan.scan_time, but over what the log says [s]"}, l.scan_time,
        Real{0, 1});
  visit(Setting{group, "stamp_at", "As scan.stamp_at"}, l.stamp_at, kStampAts);
}

/// "lidars.front"
inline std::string lidar_group(const LidarConfig& lidar) {
  return std::string(kLidars.name) + "." + lidar.name;
}

}  // namespace parloc
