#include "common/flow/flow_filter.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/error.h"
#include "common/filter/map_frame.h"
#include "common/filter/run_digest.h"
#include "common/filter/start.h"
#include "common/filter/step_front_end.h"
#include "common/flow/flow_backend.h"
#include "common/flow/mean_update.h"

namespace parloc {
namespace {

constexpr double kStiff = 100.0;  // s / r from which Euler steps leave the cloud twice too wide (SPEC 7.6)

const char* text_of(FlowSkip skip) {
  switch (skip) {
    case FlowSkip::none:
      return "";
    case FlowSkip::no_scan:
      return "too few beams";
    case FlowSkip::no_slope:
      return "no beam ends near a wall of the map";
    case FlowSkip::gated:
      return "the scan is farther off than flow.gate_nis allows";
    case FlowSkip::no_update:
      break;
  }
  return "the information matrix is singular";
}

Covariance covariance_of(const Matrix3& p) {
  Covariance c;
  std::copy_n(p.m, 9, c.v);
  return c;
}

/// The start's Gaussian, whose axes are the map's, in the grid frame.
PoseGaussian start_gaussian(const GridMap& map, const Pose& pose, double sx, double sy, double st) {
  const Pose in_grid = relative(pose, map.T_map_grid);
  const Covariance c = turned({{sx * sx, 0, 0, 0, sy * sy, 0, 0, 0, st * st}}, -map.T_map_grid.theta_rad);
  PoseGaussian g;
  g.mean[0] = in_grid.x_m, g.mean[1] = in_grid.y_m, g.mean[2] = in_grid.theta_rad;
  std::copy_n(c.v, 9, g.covariance.m);
  g.covariance = proper_covariance(g.covariance);
  return g;
}

/// The filter's Gaussian, about the particles' mean if there are any.
PoseEstimate estimate_of(const FlowState& s, FlowMethod method, const Pose& T_map_grid) {
  PoseEstimate e;
  const Vector3 mean = is_kalman(method) ? s.posterior.mean : mean_of(s.cloud);
  e.mean = compose(T_map_grid, {mean[0], mean[1], mean[2]});
  e.covariance = turned(covariance_of(s.posterior.covariance), T_map_grid.theta_rad);
  e.weight = 1.0;
  e.heading_resultant = is_kalman(method) ? 1.0 : s.cloud.resultant;
  return e;
}

/// What the particles alone say.
PoseEstimate cloud_of(const FlowState& s, const Pose& T_map_grid) {
  PoseEstimate e = in_map_frame(s.cloud, T_map_grid);
  e.weight = 1.0;
  return e;
}

}  // namespace

struct FlowFilter::State {
  State(FlowMethod m, const FlowFilterConfig& c) : method(m), config(c), front_end(config) {}

  FlowMethod method;
  FlowFilterConfig config;
  GridMap map;
  std::unique_ptr<FlowBackend> backend;
  BeamTable beams;
  StepFrontEnd front_end;
  Estimate last;
  FlowSkip skip = FlowSkip::no_scan;
  std::size_t stiff = 0, steps = 0;
  bool started = false;
  RunDigest digest;

  std::int64_t particles() const { return is_kalman(method) ? 0 : config.particles; }
  Estimate to_estimate(const FlowState& s) const;
  void remember(const FlowState& s, const Estimate& e);
};

Estimate FlowFilter::State::to_estimate(const FlowState& s) const {
  Estimate e;
  e.mean = estimate_of(s, method, map.T_map_grid);
  e.cluster = is_kalman(method) ? e.mean : cloud_of(s, map.T_map_grid);
  e.pose = e.mean.mean;
  e.covariance = e.mean.covariance;
  e.ambiguous_heading = e.mean.heading_resultant < 1e-3;
  e.particles = static_cast<std::size_t>(particles());
  e.n_eff = static_cast<double>(e.particles);
  e.weighted = s.skip == FlowSkip::none;
  if (method == FlowMethod::pfpf) {
    const StepState& w = backend->weights_state();
    e.n_eff = w.n_eff;
    e.resampled = w.resample != 0;
    e.lost = e.weighted && w.degenerate != 0;
  }
  return e;
}

void FlowFilter::State::remember(const FlowState& s, const Estimate& e) {
  skip = s.skip;
  const bool euler = config.flow.integrator == FlowIntegrator::euler ||
                     (method == FlowMethod::edh && config.flow.integrator == FlowIntegrator::automatic);
  const bool steps_lag = !is_kalman(method) && method != FlowMethod::naedh && method != FlowMethod::gromov;
  stiff += euler && steps_lag && s.skip == FlowSkip::none && s.stiffness > kStiff ? 1 : 0;
  digest.add(e);
  last = e;
}

FlowFilter::FlowFilter(FlowMethod method, const FlowFilterConfig& config, const GridMap& map)
    : state_(std::make_unique<State>(method, config)) {
  validate(config);
  check_has_free_cell(map);
  State& s = *state_;
  s.map = map;
  std::string why;
  s.backend = make_flow_backend(
      config.backend, {s.particles(), config.threads, config.device, config.flow, method, config.resample},
      why);
  s.backend->set_map(map);
}

FlowFilter::~FlowFilter() = default;

void FlowFilter::start_at(const Pose& pose, double sigma_x_m, double sigma_y_m, double sigma_theta_rad) {
  State& s = *state_;
  check_start(s.map, pose, sigma_x_m, sigma_y_m, sigma_theta_rad);
  s.backend->start(
      gaussian_start(s.map, pose, sigma_x_m, sigma_y_m, sigma_theta_rad, s.particles(), s.config.seed),
      start_gaussian(s.map, pose, sigma_x_m, sigma_y_m, sigma_theta_rad));
  s.front_end.clear();
  s.last = {};
  s.last.pose = pose;
  s.skip = FlowSkip::no_scan;
  s.stiff = s.steps = 0;
  s.digest = {};
  s.started = true;
}

void FlowFilter::set_seed(std::uint64_t seed) {
  state_->config.seed = seed;
}

void FlowFilter::add_odometry(double stamp_s, const Pose& odometry) {
  state_->front_end.add_odometry(stamp_s, odometry);
}

Estimate FlowFilter::step(const Pose& recorded, const Scan& scan) {
  State& s = *state_;
  if (!s.started) throw Error(ErrorKind::internal, "FlowFilter::step before start_at");
  const std::optional<OdometryReading> odometry = s.front_end.take_odometry(scan.stamp_s, recorded);
  if (!odometry) {
    Estimate e = s.last;
    e.weighted = e.resampled = e.lost = false;
    return e;
  }
  const FlowFilterConfig& c = s.config;
  // What the sensor models of a particle filter need of a beam is not read here.
  const bool enough = s.front_end.take(scan, SensorConfig{}, s.map.resolution_m, s.beams) &&
                      s.beams.hits >= static_cast<std::size_t>(c.scan.min_beams);
  const MotionStep motion = motion_step(s.front_end.move_to(odometry->pose), c.motion);
  const RandomKey key{c.seed, static_cast<std::uint32_t>(s.steps)};
  const FlowState& state = s.backend->step(motion, key, enough ? &s.beams : nullptr);
  const Estimate e = s.to_estimate(state);
  s.remember(state, e);
  ++s.steps;
  return e;
}

std::string FlowFilter::why_skipped() const {
  return text_of(state_->skip);
}

std::vector<Particle> FlowFilter::particles(std::size_t most) const {
  return in_map_frame(state_->backend->download(), state_->map.T_map_grid, most);
}

BeamCounts FlowFilter::beam_counts() const {
  return state_->front_end.intake().total();
}
const std::vector<LidarUse>& FlowFilter::lidars_used() const {
  return state_->front_end.intake().used();
}
std::size_t FlowFilter::odometry_jumps() const {
  return state_->front_end.continuous().jumps();
}
std::size_t FlowFilter::odometry_invalid() const {
  return state_->front_end.continuous().invalid();
}
std::size_t FlowFilter::stiff_scans() const {
  return state_->stiff;
}
std::size_t FlowFilter::steps() const {
  return state_->steps;
}
std::string FlowFilter::backend_name() const {
  return state_->backend->name();
}
const FlowFilterConfig& FlowFilter::config() const {
  return state_->config;
}
const GridMap& FlowFilter::map() const {
  return state_->map;
}

std::string FlowFilter::digest() const {
  return state_->digest.hex_with(state_->backend->download());
}

}  // namespace parloc
