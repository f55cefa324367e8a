#include "common/config/nav2_parameters.h"

#include <algorithm>

namespace parloc {
namespace {

constexpr const char* kTransforms = "no transforms are sent";
constexpr const char* kOfBag = "of a bag";
constexpr const char* kNode = "about the node, not about localization";
constexpr const char* kAnyMotion = "0 of either: any motion, so every scan";

}  // namespace

const std::vector<Nav2Parameter>& nav2_parameters() {
  using enum Nav2Fate;
  static const std::vector<Nav2Parameter> parameters{
      {"allow_parameter_qos_overrides", "true", none, "", kNode},
      {"alpha1", "0.2", same, "motion.alpha1", "with motion.form: thrun or omni"},
      {"alpha2", "0.2", same, "motion.alpha2", "with motion.form: thrun or omni"},
      {"alpha3", "0.2", same, "motion.alpha3", "with motion.form: thrun or omni"},
      {"alpha4", "0.2", same, "motion.alpha4", "with motion.form: thrun or omni"},
      {"alpha5", "0.2", same, "motion.alpha5", "only motion.form: omni reads it"},
      {"always_reset_initial_pose", "false", none, "", "a run starts once"},
      {"autostart_node", "false", none, "", kNode},
      {"base_frame_id", "base_footprint", same, "log.base_frame", kOfBag},
      {"beam_skip_distance", "0.5", same, "sensor.beam_skip_distance", ""},
      {"beam_skip_error_threshold", "0.9", same, "sensor.beam_skip_error_threshold", ""},
      {"beam_skip_threshold", "0.3", same, "sensor.beam_skip_threshold", ""},
      {"bond_heartbeat_period", "0.1", none, "", kNode},
      {"do_beamskip", "false", same, "sensor.do_beamskip", ""},
      {"first_map_only", "false", none, "", "a run has one map"},
      {"freespace_downsampling", "false", none, "", "free space takes no memory of its own here"},
      {"global_frame_id", "map", none, "", "poses are in the map's frame, whatever its name"},
      {"initial_pose.x", "0.0", adapted, "--init", "with set_initial_pose: true, where --init is not given"},
      {"initial_pose.y", "0.0", adapted, "--init", "with set_initial_pose: true, where --init is not given"},
      {"initial_pose.yaw", "0.0", adapted, "--init",
       "with set_initial_pose: true, where --init is not given"},
      {"initial_pose.z", "0.0", none, "", "poses are in the plane"},
      {"introspection_mode", "disabled", none, "", kNode},
      {"lambda_short", "0.1", same, "sensor.lambda_short", "only sensor.model: beam reads it"},
      {"laser_likelihood_max_dist", "2.0", same, "sensor.laser_likelihood_max_dist", ""},
      {"laser_max_range", "100.0", adapted, "scan.laser_max_range",
       "where the log gives none: no cap on what it gives; -1: as the log says"},
      {"laser_min_range", "-1.0", adapted, "scan.laser_min_range",
       "where the log gives none: no floor under what it gives; -1: as the log says"},
      {"laser_model_type", "likelihood_field", adapted, "sensor.model", "the models have the same names"},
      {"map_topic", "map", same, "log.map_topic", "where the map is in a bag"},
      {"max_beams", "60", same, "scan.max_beams", ""},
      {"max_particles", "2000", same, "max_particles", ""},
      {"min_particles", "500", same, "min_particles", ""},
      {"odom_frame_id", "odom", adapted, "log.odometry_frame",
       "of a bag; odom: a topic of odometry is read first, if there is one"},
      {"pf_err", "0.05", same, "kld.pf_err", ""},
      {"pf_z", "0.99", same, "kld.pf_z", "a normal quantile, as nav2 reads it"},
      {"random_seed", "-1", adapted, "seed", "below 0: parloc's, since a run is to be repeatable"},
      {"recovery_alpha_fast", "0.0", same, "recovery.recovery_alpha_fast", ""},
      {"recovery_alpha_slow", "0.0", same, "recovery.recovery_alpha_slow", ""},
      {"resample_interval", "1", adapted, "resample.threshold",
       "1: every step; else parloc resamples by N_eff, not by counting"},
      {"robot_model_type", "nav2_amcl::DifferentialMotionModel", adapted, "motion.form",
       "differential is thrun, omnidirectional is omni"},
      {"save_pose_rate", "0.5", none, "", "every pose is in the results"},
      {"scan_topic", "scan", same, "log.scan_topic", kOfBag},
      {"service_introspection_mode", "disabled", none, "", kNode},
      {"set_initial_pose", "false", adapted, "--init",
       "true: start at initial_pose, where --init is not given"},
      {"sigma_hit", "0.2", same, "sensor.sigma_hit", ""},
      {"tf_broadcast", "true", none, "", kTransforms},
      {"transform_tolerance", "1.0", none, "", kTransforms},
      {"update_min_a", "0.2", same, "update_min_a", kAnyMotion},
      {"update_min_d", "0.25", same, "update_min_d", kAnyMotion},
      {"use_sim_time", "false", none, "", "the time is that of the log"},
      {"z_hit", "0.5", adapted, "sensor.z_hit", "the shares that a model reads are scaled to sum to 1"},
      {"z_max", "0.05", adapted, "sensor.z_max", "only sensor.model: beam reads it"},
      {"z_rand", "0.5", adapted, "sensor.z_rand", "the shares that a model reads are scaled to sum to 1"},
      {"z_short", "0.05", adapted, "sensor.z_short", "only sensor.model: beam reads it"},
  };
  return parameters;
}

const Nav2Parameter* nav2_parameter(std::string_view name) {
  const std::vector<Nav2Parameter>& all = nav2_parameters();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Nav2Parameter& p) { return name == p.name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace parloc
