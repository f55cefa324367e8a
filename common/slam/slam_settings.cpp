#include "common/slam/slam_settings.h"

#include "common/filter/filter_settings.h"
#include "common/model/model_settings.h"

namespace parloc {
namespace {

const std::vector<Choice<SlamOdometry>> kSlamOdometries{{"recorded", SlamOdometry::recorded},
                                                        {"scans", SlamOdometry::scans}};

}  // namespace

void add_slam_settings(Settings& s, SlamConfig& slam, int& max_beams, double& update_min_d,
                       double& update_min_a) {
  s.group("slam", "Mapping without a map (docs/slam.md); the filters on a map do not read it.");
  s.add("particles", "Each with a map of its own", slam.particles, {1, 65'535});
  s.add("proposal", "From odometry alone, the best fit near it, or drawn around that", slam.proposal,
        kSlamProposals);
  s.add("odometry", "As recorded, or from the scans alone", slam.odometry, kSlamOdometries);
  s.add("max_beams", "Beams used of a scan, in place of scan.max_beams", max_beams,
        {1, static_cast<int>(kMostSlamBeams)});
  s.add("resolution", "Cell size of the maps [m]", slam.resolution, {0.005, 1});
  s.add("clear_range", "Beams that saw nothing clear their way so far; 0: they say nothing [m]",
        slam.clear_range, {0.0, 200});
  s.add("usable_range", "Beams are cut here: farther ends are not used [m]", slam.usable_range, {0.1, 200});
  s.add("update_min_d", "Take a scan in after this much translation [m]; 0: no criterion", update_min_d,
        {0, 100});
  s.add("update_min_a", "... or after this much rotation [rad]; both 0: every scan", update_min_a, {0, 100});
  s.add("resample_threshold", "Resample when N_eff < threshold * N; 1: every time", slam.resample_threshold,
        {0, 1});
  s.add("beta_weight", "Exponent of a scan's likelihood in the weights", slam.beta_weight, {0, 1, true});
  s.add("beta_proposal", "... in the gaussian proposal", slam.beta_proposal, {0, 1, true});
  s.add("search_xy", "The matcher first searches all poses so far around [m]", slam.search_xy, {0, 5});
  s.add("search_theta", "... [rad]; both 0: it only climbs", slam.search_theta, {0, 3.1416});
  s.add("search_bias", "Score per beam that a pose at its rim must have more", slam.search_bias, {0, 1});
  s.add("step_xy", "First step of the scan matcher [m]", slam.step_xy, {0, 1, true});
  s.add("step_theta", "... [rad]", slam.step_theta, {0, 1, true});
  s.add("iterations", "Times that it halves its steps", slam.iterations, {1, 20});
  s.add("sigma_score", "Of the matcher's score, exp(-d^2 / sigma) [m^2]", slam.sigma_score, {0, 10, true});
  s.add("sigma_likelihood", "Of a beam's log-likelihood, -d^2 / sigma [m^2]", slam.sigma_likelihood,
        {0, 10, true});
  s.add("min_score", "Score per beam below which matching has failed", slam.min_score, {0, 1});
  s.add("box_xy", "gaussian: half the box that is looked at [m]", slam.box_xy, {0, 1, true});
  s.add("box_theta", "... [rad]", slam.box_theta, {0, 1, true});
  s.add("motion_floor_xy", "Motion noise besides, whatever the motion [m]", slam.motion_floor_xy,
        {0, 10, true});
  s.add("motion_floor_theta", "... [rad]", slam.motion_floor_theta, {0, 10, true});
  s.add("occupied_above", "Share of beams ending there from which a cell is a wall", slam.occupied_above,
        {0, 1});
  s.add("close_loops", "Distribute over the way what loops leave over, and draw the map anew",
        slam.close_loops);
  s.add("memory_mib", "Most that the tiles of all maps take [MiB]; 0: no limit", slam.memory_mib,
        {0, 10'000'000});
}

Settings settings_of(GridSlamConfig& config) {
  Settings s;
  add_seed(s, config.seed);
  add_settings(s, static_cast<ComputeConfig&>(config));
  add_settings(s, config.motion);
  add_settings(s, config.scan);
  add_slam_settings(s, config.slam, config.scan.max_beams, config.update_min_d, config.update_min_a);
  s.named = named_settings(config.lidars);
  return s;
}

std::string config_difference(GridSlamConfig there, GridSlamConfig here) {
  return settings_difference(settings_of(there), settings_of(here), {"backend", "threads", "device"});
}

void validate(const GridSlamConfig& config) {
  GridSlamConfig copy = config;
  require_none(first_beyond_limits(settings_of(copy)));
  require_none(broken_rule(config));
}

}  // namespace parloc
